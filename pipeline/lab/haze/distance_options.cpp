#include "pipeline/lab/haze/distance_options.hpp"

#include <CLI/CLI.hpp>

namespace kasumi {

void add_distance_options(CLI::App& command, DistanceOptions& options, const std::string& zero) {
  command.add_option("--depth", options.depth,
                     "Distances: PFM, EXR or TIFF of metres, or a PNG of 16 bits; 0: " + zero);
  command
      .add_option("--depth-step-m", options.step_m,
                  "Metres per step of the PNG, or per unit of floats (.001: millimetres; with --disparity: pixels)")
      ->check(CLI::Range(1e-5, 1e3));
  command.add_option("--disparity", options.disparity, "Instead of --depth: disparities in pixels, from a stereo pair");
  command
      .add_option("--disparity-scale", options.disparity_scale, "Focal length times baseline, in pixels times metres")
      ->check(CLI::Range(1e-6, 1e9));
  command.add_option("--disparity-offset-px", options.disparity_offset_px, "Added to disparities (Middlebury: doffs)")
      ->check(CLI::Range(-1e4, 1e4))
      ->capture_default_str();
  command.add_option("--inverse-depth", options.inverse_depth,
                     "Instead of --depth: nearness, as networks give it; 1 / metres = scale v + offset");
  command.add_option("--inverse-scale", options.inverse_scale, "1 / metres per unit of --inverse-depth")
      ->check(CLI::Range(1e-12, 1e12));
  command.add_option("--inverse-offset", options.inverse_offset, "1 / metres where --inverse-depth is 0")
      ->check(CLI::Range(-1e6, 1e6))
      ->capture_default_str();
  command.add_option("--no-data", options.no_data,
                     "The number in the file that stands for no distance (also NaN, and "
                     "65535 of 16 bits)");
  command.add_option("--sky-beyond-m", options.sky_beyond_m, "What is farther is sky, as infinity is")
      ->check(CLI::Range(1.0, 400e3))
      ->capture_default_str();
  command.add_option("--depth-channel", options.channel, "Channel of an EXR; default: Z, *.Z, V, Y, or R of grey");
}

std::optional<DistanceMap> read_distances(const DistanceOptions& options, bool zero_is_sky, int width, int height,
                                          Problems& problems) {
  DistanceFile file;
  file.scale = options.step_m;
  file.no_data = options.no_data;
  file.sky_beyond_m = options.sky_beyond_m;
  file.channel = options.channel;
  file.zero_is_sky = zero_is_sky;
  if (options.disparity.empty() && options.disparity_scale)
    problems.add("--disparity-scale: expected together with --disparity");
  if (options.inverse_depth.empty() && options.inverse_scale)
    problems.add("--inverse-scale: expected together with --inverse-depth");
  if (!options.disparity.empty()) {
    if (!options.disparity_scale)
      problems.add("--disparity: expected --disparity-scale, focal length times baseline, in pixels times metres");
    // A step is so many pixels: scale / (step v + offset) = (scale / step) / (v + offset / step).
    const double step = options.step_m.value_or(1.0);
    file.holds = DistanceFile::Holds::disparity;
    file.scale = options.disparity_scale.value_or(1.0) / step;
    file.offset = options.disparity_offset_px / step;
  }
  if (!options.inverse_depth.empty()) {
    if (!options.inverse_scale)
      problems.add(
          "--inverse-depth: expected --inverse-scale (and --inverse-offset): without two known distances "
          "nearness is no distance. Where v is v1 at d1 metres and v2 at d2, the scale is (1 / d1 - 1 / d2) / "
          "(v1 - v2) and the offset 1 / d1 - scale v1");
    if (options.step_m) problems.add("--depth-step-m: not with --inverse-depth, whose scale it would be");
    file.holds = DistanceFile::Holds::inverse;
    file.scale = options.inverse_scale.value_or(1.0);
    file.offset = options.inverse_offset;
  }
  auto map = read_distances(options.path(), file, width, height);
  const bool is_told = (options.disparity.empty() || options.disparity_scale) &&
                       (options.inverse_depth.empty() || options.inverse_scale);
  if (map && !is_told) return std::nullopt;
  if (!map) {
    problems.add("{}", map.error().message);
    return std::nullopt;
  }
  fmt::print("{}: {}\n", options.path(), map->summary());
  return std::move(*map);
}

}  // namespace kasumi
