// What `kasumi estimate` says of a photograph of the sky.
#pragma once

#include <filesystem>
#include <string>

#include "pipeline/lab/photographs/sky_photograph.hpp"

namespace kasumi {

// One JSON object and a newline; `landmarks`: a JSON object stored under that key, or empty.
std::string estimate_json(const std::filesystem::path& image, const PhotographReport& report,
                          const std::string& landmarks);
// Where the file's place is not the one given (off_m): "its EXIF says 35.000 N, 135.000 E, 412 km away".
std::string other_place(const PhotographReport& report);
// Text for people.
std::string estimate_text(const std::filesystem::path& image, const PhotographReport& report);

}  // namespace kasumi
