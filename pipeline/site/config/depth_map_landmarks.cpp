#include "pipeline/site/config/depth_map_landmarks.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace kasumi {
namespace {

constexpr double kNearest_m = 300.0, kFarthest_m = 50e3;
constexpr float kAtOneDistance = 0.08F;
constexpr double kAnotherDistance = 0.1;  // of its logarithm
constexpr double kContrast = 0.75, kContrastSigma = 0.2;

struct LevelBox {
  LandmarkBox box;
  double distance_m = 0.0;
  double off_horizon = 0.0;
};

std::optional<LevelBox> level_box(const LandmarkContext& scene, const LandmarkBox& box) {
  const auto& map = *scene.distances_m;
  float nearest = 1e9F, farthest = 0.0F;
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) {
      nearest = std::min(nearest, map.at(x, y));
      farthest = std::max(farthest, map.at(x, y));
    }
  if (!(nearest >= static_cast<float>(kNearest_m) && farthest <= static_cast<float>(kFarthest_m)) ||
      farthest - nearest > kAtOneDistance * nearest)
    return std::nullopt;
  const double distance_m = 0.5 * (static_cast<double>(nearest) + static_cast<double>(farthest));
  // Without a camera the land's upper edge is what comes nearest to the horizon.
  const double off = scene.camera ? std::abs(rise_of(scene, box, distance_m)) / distance_m : box.y;
  return LevelBox{box, distance_m, off};
}

}  // namespace

MappedDistance mapped_distance(const LandmarkContext& scene, const LandmarkBox& box,
                               const std::optional<RidgeStrip>& ridge) {
  MappedDistance found;
  if (!scene.distances_m || scene.distances_m->empty()) return found;
  std::vector<float> known;
  std::size_t all = 0;
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) {
      if (!scene.distances_m->contains(x, y) || (ridge && !ridge->contains(x, y))) continue;
      ++all;
      if (scene.distances_m->at(x, y) > 0.0F) known.push_back(scene.distances_m->at(x, y));
    }
  if (known.empty() || 2 * known.size() <= all) return found;
  std::ranges::sort(known);
  const auto at = [&](double share) {
    return static_cast<double>(known[static_cast<std::size_t>(share * static_cast<double>(known.size() - 1))]);
  };
  return {true, at(0.5), at(0.1), at(0.9)};
}

double rise_of(const LandmarkContext& scene, const LandmarkBox& box, double distance_m) {
  if (!scene.camera) return 0.0;
  const auto direction = scene.camera->direction_at({box.x + 0.5 * box.width, box.y + 0.5 * box.height});
  return direction ? distance_m * direction->z : 0.0;
}

std::vector<ContrastLandmark> landmarks_in(const LandmarkContext& scene, const std::string& name, int count) {
  if (!scene.distances_m || scene.distances_m->empty()) return {};
  const int width = std::max(4, scene.width / 24), height = std::max(2, scene.height / 60);
  std::vector<LevelBox> boxes;
  for (int y = 0; y + height <= scene.height; y += std::max(1, height / 2))
    for (int x = 0; x + width <= scene.width; x += std::max(1, width / 2))
      if (const auto box = level_box(scene, {x, y, width, height})) boxes.push_back(*box);
  if (boxes.empty()) return {};
  const auto [first, last] = std::ranges::minmax(boxes, {}, &LevelBox::distance_m);
  const double from = first.distance_m, reach = std::log(last.distance_m / from) + 1e-9;
  std::vector<std::optional<LevelBox>> best(static_cast<std::size_t>(count));
  for (const auto& box : boxes) {
    auto& held = best[static_cast<std::size_t>(count * std::log(box.distance_m / from) / reach)];
    if (!held || box.off_horizon < held->off_horizon) held = box;
  }
  std::vector<LevelBox> chosen;
  for (const auto& box : best)
    if (box) chosen.push_back(*box);
  // Where steps are empty, what is nearest to the horizon elsewhere at another distance.
  std::ranges::stable_sort(boxes, {}, &LevelBox::off_horizon);
  for (const auto& box : boxes) {
    if (chosen.size() >= static_cast<std::size_t>(count)) break;
    const auto same = [&](const LevelBox& other) {
      return std::abs(std::log(box.distance_m / other.distance_m)) < kAnotherDistance;
    };
    if (std::ranges::none_of(chosen, same)) chosen.push_back(box);
  }
  std::ranges::sort(chosen, {}, &LevelBox::distance_m);
  std::vector<ContrastLandmark> found;
  for (const auto& box : chosen) {
    ContrastLandmark landmark;
    landmark.name = fmt::format("{}, {:.2f} km", name, box.distance_m / 1e3);
    landmark.distance_m = box.distance_m;
    landmark.rise_m = rise_of(scene, box.box, box.distance_m);
    landmark.surface = box.box;
    landmark.contrast = kContrast;
    landmark.contrast_sigma = kContrastSigma;
    found.push_back(std::move(landmark));
  }
  return found;
}

}  // namespace kasumi
