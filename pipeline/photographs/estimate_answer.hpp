// What `kasumi estimate` says of a photograph of the sky.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/photographs/sky_photograph.hpp"

namespace kasumi {

// One JSON object, with line break; `landmarks`: another that becomes its key of that name, or nothing.
std::string estimate_json(const std::filesystem::path& image, const SkyPhotographReport& report,
                          const std::string& landmarks);
// Lines for a person.
std::string estimate_text(const std::filesystem::path& image, const SkyPhotographReport& report);

}  // namespace kasumi
