#include "pipeline/lab/look/turntable.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "gles/gl/offscreen.hpp"
#include "pipeline/show/scene/compositor.hpp"

namespace kasumi {

namespace {

constexpr int kViewWidth = 480, kViewHeight = 360;
constexpr double kViewFocal_px = 660.0;
constexpr double kLookDown_deg = 8.0;
constexpr double kRadius_m = 30.0;  // every model is drawn as large as a temple, so that no air is in between

SkyReport clear_afternoon() {
  SkyReport report;
  report.sun.source = SunSource::ephemeris;
  report.sun.direction = glm::normalize(glm::dvec3{-0.5, -0.65, 0.6});
  report.estimate.sky = SkyCondition::clear;
  return report;
}

// The sky that lights the model, over plain land, as the camera encodes it: another sky's colours would be taken for the
// camera's white balance.
Image<Rgb8> backdrop(const Installation& installation) {
  constexpr double kHorizon = 0.34, kLand = 0.3;  // green, linear; of the horizon's light
  const glm::dvec3 grass{0.8, 1.0, 0.5};
  const Camera& camera = installation.scene;
  const auto conditions = SceneAir(installation, {}).conditions(clear_afternoon());
  const auto& around = installation.surroundings;
  const Daylight daylight(
      camera, conditions.air, conditions.sun,
      {conditions.sky, around.ground_albedo, installation.site.altitude_m, around.sky_model, nullptr, 1.0});
  const auto light_from = [&](const Direction& direction) {
    return daylight.airlight(direction) * camera.white_balance;
  };
  const glm::dvec3 ahead = camera.to_world * glm::dvec3{0.0, 0.0, 1.0};
  const double unit = kHorizon / light_from(glm::normalize(glm::dvec3{ahead.x, ahead.y, 0.0})).g;
  Image<Rgb8> picture(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Direction direction = camera.direction_at({x, y}).value_or(Direction{0.0, 0.0, 1.0});
      const glm::dvec3 sky = unit * light_from(direction);
      const glm::dvec3 light = glm::mix(sky, kLand * grass * sky.g, std::clamp(-60.0 * direction.z, 0.0, 1.0));
      picture.at(x, y) = Rgb8(glm::round(255.0 * glm::clamp(camera.response.to_encoded(light), 0.0, 1.0)));
    }
  }
  return picture;
}

Frame frame_of(const Image<Rgb8>& picture) {
  Frame frame;
  frame.metadata.format = four_cc("RGB3");
  frame.metadata.width = picture.width();
  frame.metadata.height = picture.height();
  frame.metadata.stride = static_cast<std::uint32_t>(3 * picture.width());
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(picture.elements().data());
  std::vector<std::uint8_t> copy(bytes, bytes + 3 * picture.elements().size());
  frame.metadata.bytes_used = static_cast<std::uint32_t>(copy.size());
  frame.payload = payload_of(std::move(copy));
  return frame;
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

Result<Image<Rgb8>> drawn_over_backdrop(GlContext& context, const Installation& installation, const Model& model) {
  auto compositor = Compositor::create(context, installation, model, SceneAirOptions{});
  if (!compositor) return fail(compositor.error());
  auto target = Offscreen::create(context.info(), installation.scene.width, installation.scene.height);
  if (!target) return fail(target.error());
  const auto frame = frame_of(backdrop(installation));
  if (auto drawn = compositor->draw(frame, clear_afternoon(), target->target()); !drawn) return fail(drawn.error());
  return target->read();
}

Installation table_for(const Model& model, UpAxis up, int side) {
  Installation table;
  table.site = {"", 34.0, 135.0, 100.0};
  table.surroundings.sky_model = SiteSkyModel::dome;
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
    auto view = drawn_over_backdrop(context, table_for(model, up, side), model);
    if (!view) return fail(view.error());
    views.push_back(std::move(*view));
  }
  return views;
}

Result<KioskView> seen_from_kiosk(GlContext& context, const Installation& installation, const Model& model) {
  auto whole = drawn_over_backdrop(context, installation, model);
  if (!whole) return fail(whole.error());
  auto enlarged = changed_part(*whole, backdrop(installation));
  return KioskView{std::move(*whole), std::move(enlarged)};
}

}  // namespace kasumi
