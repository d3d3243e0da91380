#include "estimator/horizon/low_sky.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "base/statistics.hpp"
#include "estimator/horizon/horizon.hpp"
#include "estimator/horizon/strips.hpp"

namespace kasumi {
namespace {

constexpr int kStripsOfLowSky = 16;          // across the picture
constexpr int kPatchesInStrip = 2;           // side by side: 32 across the picture
constexpr double kPatchHeight = 1.0 / 60.0;  // of the picture
constexpr int kPixelsOfPatch = 48;           // noise of the mean is a seventh of a pixel's
constexpr double kLeastSkyShare = 0.95;      // of a patch
// Chosen: as few as hot pixels and noise clip, while a burnt sky clips more.
constexpr double kMostClippedShare = 0.02;
// Of ln light within a patch, beyond noise and the sky's own gradient: a cloud's edge.
constexpr double kRoughest = 0.02;
constexpr double kMostRough = 0.25;  // of the patches: else there are clouds
constexpr std::size_t kFewestPatches = 24;
constexpr double kLeastHeight_rad = 0.035;  // two degrees of elevation that the patches must span

struct Block {
  int x0 = 0, x1 = 0, y0 = 0, y1 = 0;
};

struct BlockPatch {
  HorizonPatch patch;
  bool rough = false;
};

// Deviations from the plane through the block, since a clear sky has a gradient, too.
std::vector<double> off_plane(const std::vector<glm::dvec2>& places, const std::vector<double>& values) {
  glm::dvec2 middle{0.0};
  double mean = 0.0;
  const auto count = static_cast<double>(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    middle += places[i] / count;
    mean += values[i] / count;
  }
  double xx = 1e-9, xy = 0.0, yy = 1e-9, xv = 0.0, yv = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const glm::dvec2 at = places[i] - middle;
    const double v = values[i] - mean;
    xx += at.x * at.x;
    xy += at.x * at.y;
    yy += at.y * at.y;
    xv += at.x * v;
    yv += at.y * v;
  }
  const double determinant = xx * yy - xy * xy;
  const double by_x = (yy * xv - xy * yv) / determinant, by_y = (xx * yv - xy * xv) / determinant;
  std::vector<double> off;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const glm::dvec2 at = places[i] - middle;
    off.push_back(values[i] - mean - by_x * at.x - by_y * at.y);
  }
  return off;
}

std::optional<BlockPatch> light_of(const HorizonPixels& scene, const Block& block) {
  const glm::dvec2 centre{0.5 * (block.x0 + block.x1 - 1), 0.5 * (block.y0 + block.y1 - 1)};
  const auto direction = scene.camera.direction_at(centre);
  if (!direction) return std::nullopt;
  const double elevation = 0.5 * kPi - zenith_angle(*direction).value;
  if (elevation < kLowestLowSky.value || elevation > kHighestLowSky.value) return std::nullopt;

  std::vector<double> log_light[3];
  std::vector<glm::dvec2> places;
  int seen = 0, clipped = 0;
  const int width = block.x1 - block.x0, pixels = width * (block.y1 - block.y0);
  const int stride = std::max(1, pixels / kPixelsOfPatch);
  for (int i = 0; i < pixels; i += stride) {
    const int x = block.x0 + i % width, y = block.y0 + i / width;
    ++seen;
    clipped += scene.clipped_at(x, y) ? 1 : 0;
    const glm::dvec3 light = scene.light_at(x, y);
    if (scene.sky.at(x, y) == 0 || std::min({light.r, light.g, light.b}) <= 0.0) continue;
    places.push_back({x, y});
    for (int c = 0; c < 3; ++c) log_light[c].push_back(std::log(light[c]));
  }
  const auto count = static_cast<double>(places.size());
  if (count < kLeastSkyShare * seen || clipped > kMostClippedShare * seen || count < 8.0) return std::nullopt;

  BlockPatch found;
  found.patch.direction = *direction;
  const glm::dvec2 middle{0.5 * scene.camera.width, 0.5 * scene.camera.height};
  found.patch.off_axis = glm::length(centre - middle) / glm::length(middle);
  const glm::dvec3 step = scene.log_step_at(static_cast<int>(centre.x), static_cast<int>(centre.y));
  for (int c = 0; c < 3; ++c) {
    const double scatter = robust_sigma(off_plane(places, log_light[c]));
    found.rough = found.rough || scatter > std::hypot(kRoughest, 2.0 * step[c]);
    found.patch.light[c] = std::exp(median(log_light[c]));
    found.patch.sigma[c] = std::hypot(kMedianErrorOverMeanError * scatter / std::sqrt(count), 0.3 * step[c]);
  }
  return found;
}

// Of one strip, from the land up to the picture's upper edge.
std::vector<Block> blocks_of(const HorizonPixels& scene, const HorizonStrip& strip) {
  std::vector<Block> blocks;
  const int height = std::max(3, static_cast<int>(kPatchHeight * scene.picture.height()));
  const int margin = std::max(2, static_cast<int>(kHorizonMargin * scene.picture.height()));
  const int lowest = std::min(strip.certain, strip.first_drop) - margin;
  for (int y1 = lowest; y1 - height >= 0; y1 -= height)
    for (int k = 0; k < kPatchesInStrip; ++k) {
      const int width = strip.x1 - strip.x0;
      const Block block{strip.x0 + k * width / kPatchesInStrip, strip.x0 + (k + 1) * width / kPatchesInStrip,
                        y1 - height, y1};
      if (block.x1 > block.x0) blocks.push_back(block);
    }
  return blocks;
}

}  // namespace

LowSky read_low_sky(const Camera& scene, const PictureView& picture) {
  LowSky low;
  if (picture.width != scene.width || picture.height != scene.height) {
    low.reason = fmt::format("picture is {}x{}, the scene camera {}x{}", picture.width, picture.height, scene.width,
                             scene.height);
    return low;
  }
  const Image<Rgb8> rgb = to_rgb(picture);
  const SkySegmentation segmentation = segment_sky(rgb, below_horizon(scene));
  if (!segmentation.visible) {
    low.reason = segmentation.reason;
    return low;
  }
  const HorizonPixels sky{scene, rgb, segmentation.sky};
  std::size_t rough = 0;
  double lowest = kPi, highest = 0.0;
  for (const HorizonStrip& strip : sky_strips(sky, std::min(kStripsOfLowSky, std::max(1, scene.width / 16))))
    for (const Block& block : blocks_of(sky, strip)) {
      const auto light = light_of(sky, block);
      if (!light) continue;
      if (light->rough) {
        ++rough;
        continue;
      }
      low.patches.push_back(light->patch);
      const double zenith = zenith_angle(light->patch.direction).value;
      lowest = std::min(lowest, zenith);
      highest = std::max(highest, zenith);
    }
  if (static_cast<double>(rough) > kMostRough * static_cast<double>(low.patches.size() + rough))
    low.reason = fmt::format("clouds at the horizon: {} of {} patches are rough", rough, low.patches.size() + rough);
  else if (low.patches.size() < kFewestPatches || highest - lowest < kLeastHeight_rad)
    low.reason = fmt::format("too little low sky: {} patches", low.patches.size());
  if (!low.reason.empty()) low.patches.clear();
  return low;
}

}  // namespace kasumi
