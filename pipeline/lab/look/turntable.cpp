#include "pipeline/lab/look/turntable.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "pipeline/show/scene/clear_day.hpp"

namespace kasumi {

namespace {

constexpr int kViewWidth = 480, kViewHeight = 360;
constexpr double kViewFocal_px = 660.0;
constexpr double kLookDown_deg = 8.0;
constexpr double kRadius_m = 30.0;  // every model is drawn as large as a temple, so that no air is in between

ClearDay afternoon(const Installation& installation) {
  const SkyReport sky = clear_day(kAfternoon);
  return {sky, backdrop(installation, sky)};
}

// What differs from the backdrop, with some of its surroundings.
Image<Rgb8> changed_part(const Image<Rgb8>& picture, const Image<Rgb8>& before) {
  int left = picture.width(), right = -1, top = picture.height(), bottom = -1;
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const glm::ivec3 by = glm::abs(glm::ivec3(picture.at(x, y)) - glm::ivec3(before.at(x, y)));
      if (std::max({by.x, by.y, by.z}) <= 2) continue;
      left = std::min(left, x), right = std::max(right, x), top = std::min(top, y), bottom = std::max(bottom, y);
    }
  if (right < 0) return {};
  const int margin = std::max(8, (right - left) / 4);
  left = std::max(0, left - margin), right = std::min(picture.width() - 1, right + margin);
  top = std::max(0, top - margin), bottom = std::min(picture.height() - 1, bottom + margin);
  const int times = std::max(1, kViewWidth / (right - left + 1));
  Image<Rgb8> part((right - left + 1) * times, (bottom - top + 1) * times);
  for (int y = 0; y < part.height(); ++y)
    for (int x = 0; x < part.width(); ++x) part.at(x, y) = picture.at(left + x / times, top + y / times);
  return part;
}

Installation table_for(const Model& model, UpAxis up, int side) {
  Installation table;
  table.site = {"", 34.0, 135.0, 100.0};
  table.surroundings.sky_model = DaylightModel::dome;
  Camera& camera = table.scene;
  camera.name = "scene";
  camera.width = kViewWidth;
  camera.height = kViewHeight;
  camera.lens = pinhole_lens({{kViewFocal_px, kViewFocal_px}, {0.5 * kViewWidth - 0.5, 0.5 * kViewHeight - 0.5}, {}});
  camera.to_world = camera_to_world(Radians{0.0}, from_degrees(-kLookDown_deg), Radians{0.0});
  const auto box = model.bounds();
  const glm::dvec3 lowest(box.lowest), highest(box.highest);
  Placement& placement = table.object.placement;
  placement.up_axis = up;
  placement.heading = from_degrees(45.0 * side);
  placement.scale = kRadius_m / std::max(0.5 * glm::length(highest - lowest), 1e-6);
  const glm::dvec3 centre(model_to_world(placement) * glm::dvec4(0.5 * (lowest + highest), 1.0));
  // The nearest distance at which all of it is in the picture from each side.
  const glm::dvec3 size =
      glm::abs(glm::dmat3(model_to_world({.scale = placement.scale, .up_axis = up})) * (highest - lowest));
  const double wide = 0.5 * std::hypot(size.x, size.y), high = 0.5 * size.z;
  const double away = wide + 1.1 * kViewFocal_px * std::max(wide / (0.5 * kViewWidth), high / (0.5 * kViewHeight));
  const Radians down = from_degrees(kLookDown_deg);
  placement.east_m = -centre.x;
  placement.north_m = away * std::cos(down.value) - centre.y;
  placement.up_m = -away * std::sin(down.value) - centre.z;
  return table;
}

}  // namespace

Result<std::vector<Image<Rgb8>>> turntable(GlContext& context, const Model& model, UpAxis up) {
  std::vector<Image<Rgb8>> views;
  for (int side = 0; side < 8; ++side) {
    const Installation table = table_for(model, up, side);
    auto view = drawn_over(context, table, model, {afternoon(table)});
    if (!view) return fail(view.error());
    views.push_back(std::move(view->front()));
  }
  return views;
}

Result<KioskView> seen_from_kiosk(GlContext& context, const Installation& installation, const Model& model) {
  const ClearDay day = afternoon(installation);
  auto drawn = drawn_over(context, installation, model, {day});
  if (!drawn) return fail(drawn.error());
  auto enlarged = changed_part(drawn->front(), day.backdrop);
  return KioskView{std::move(drawn->front()), std::move(enlarged)};
}

}  // namespace kasumi
