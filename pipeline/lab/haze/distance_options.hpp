// --depth, --disparity, --inverse-depth and what explains their numbers: the same for every command that takes them.
#pragma once

#include <optional>
#include <string>

#include "base/result.hpp"
#include "calib/distances/distance_map.hpp"

namespace CLI {
class App;
}

namespace kasumi {

// As typed.
struct DistanceOptions {
  std::string depth, disparity, inverse_depth, channel;
  std::optional<double> step_m, disparity_scale, inverse_scale, no_data;
  double disparity_offset_px = 0.0, inverse_offset = 0.0, sky_beyond_m = kSkyBeyond_m;

  int ways() const { return (depth.empty() ? 0 : 1) + (disparity.empty() ? 0 : 1) + (inverse_depth.empty() ? 0 : 1); }
  const std::string& path() const { return !depth.empty() ? depth : !disparity.empty() ? disparity : inverse_depth; }
};

// `zero`: what 0 is in --depth, for its help: "sky".
void add_distance_options(CLI::App& command, DistanceOptions& options, const std::string& zero);

// Prints what the map knows: "depth.pfm: 2 to 60 m in ...". Empty: a problem was added.
std::optional<DistanceMap> read_distances(const DistanceOptions& options, bool zero_is_sky, int width, int height,
                                          Problems& problems);

}  // namespace kasumi
