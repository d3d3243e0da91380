// What a kiosk shows: read completely before any of it is used.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "base/image.hpp"
#include "gles/model/model.hpp"
#include "gles/picture/flat_picture.hpp"
#include "pipeline/config/run_config.hpp"

namespace kasumi {

struct Content {
  RunConfig config;
  Model model;                        // stays in memory: GL contexts come and go
  std::optional<Image<Rgba8>> still;  // the curated picture; where it is transparent, the sky of the day shows
};
using ContentPtr = std::shared_ptr<const Content>;

// Reads configuration, calibration, model and curated picture, which BLOCKS for seconds. Errors (bad_input): all
// problems of all files at once.
Result<ContentPtr> read_content(const std::filesystem::path& config_file);

}  // namespace kasumi
