// Distance of the real scene in each pixel of a camera's picture.
#pragma once

#include <filesystem>
#include <optional>

#include "base/image.hpp"
#include "base/result.hpp"
#include "base/table/config_table.hpp"

namespace kasumi {

// depth_map and depth_step_m of [scene]: metres along each pixel's line of sight; 0 where nothing is known to stand
// (sky). A 16-bit grey PNG of whole steps, or a PFM of metres, in which infinity is nothing, too. Empty without the
// key. Problems are recorded in the table.
Image<float> read_distance_map(const ConfigTable& scene, int width, int height);

// The same for a file by itself: a grey PNG of 16 bits with the metres that a step is, or a grey PFM or EXR of metres.
// Errors: bad_input.
Result<Image<float>> read_distances(const std::filesystem::path& path, std::optional<double> step_m);

}  // namespace kasumi
