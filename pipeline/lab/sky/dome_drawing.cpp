#include "pipeline/lab/sky/dome_drawing.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth.hpp"

namespace kasumi {

PanoramaView view_of(const Viewpoint& camera) {
  PanoramaView view{camera.projection, camera.width, camera.height, 0.0, glm::dmat3(1.0)};
  const Radians heading = from_degrees(camera.heading_deg), level{0.0};
  switch (camera.projection) {
    case PanoramaProjection::perspective:
      view.focal_px = 0.5 * camera.width / std::tan(0.5 * from_degrees(camera.field_of_view_deg).value);
      view.camera_to_world = camera_to_world(heading, from_degrees(camera.pitch_deg), level);
      break;
    case PanoramaProjection::fisheye:
      view.focal_px = std::min(camera.width, camera.height) / kPi;
      view.camera_to_world = camera_to_world(heading + Radians{kPi}, from_degrees(90.0), level);
      break;
    case PanoramaProjection::equirectangular:
      view.focal_px = camera.width / (2.0 * kPi);
      view.camera_to_world = camera_to_world(heading, level, level);
      break;
  }
  return view;
}

std::optional<LandAround> land_for(const Viewpoint& camera, double observer_m, bool mountains) {
  if (camera.projection == PanoramaProjection::fisheye) return std::nullopt;
  constexpr double kHighestPeak_m = 3600.0, kHighestHill_m = 120.0;
  const Radians pitch = from_degrees(camera.pitch_deg);
  // A full circle has its seam behind the camera.
  double half = kPi - 1e-4;
  if (camera.projection == PanoramaProjection::perspective) {
    const double steepest =
        std::abs(pitch.value) +
        std::atan(std::tan(0.5 * from_degrees(camera.field_of_view_deg).value) * camera.height / camera.width);
    const double across = 0.5 * from_degrees(camera.field_of_view_deg).value;
    if (steepest < 1.0) half = std::min(half, 1.15 * std::atan(std::tan(across) / std::cos(steepest)) + 0.02);
  }
  const Radians heading = from_degrees(camera.heading_deg);
  LandView view;
  view.from = heading - Radians{half};
  view.to = heading + Radians{half};
  view.mountains = mountains;
  view.columns = std::clamp(camera.width, 200, 2000);
  view.rings = mountains ? 400 : 120;
  view.eyes_m = observer_m - synthetic_height_m({0.0, 0.0}, mountains);
  // As far down as the picture's lower edge.
  const double below = camera.projection == PanoramaProjection::perspective
                           ? std::atan(0.5 * camera.height / view_of(camera).focal_px) - pitch.value
                           : 0.5 * kPi;
  view.steepest = Radians{std::clamp(below + 0.02, 0.02, 0.5 * kPi)};
  view.row = Radians{1.0 / view_of(camera).focal_px};
  // Land there may be higher than the plain.
  const double over_land_m = std::max(view.eyes_m - (mountains ? 1000.0 : kHighestHill_m), 0.1 * view.eyes_m);
  view.nearest_m = over_land_m / std::tan(std::min(view.steepest.value, 1.5));
  const auto to_horizon = [](double h) { return std::sqrt(2.0 * kEarthRadius_m * std::max(h, 1.0)); };
  view.farthest_m = 1.02 * (to_horizon(observer_m) + to_horizon(0.5 * (mountains ? kHighestPeak_m : kHighestHill_m)));
  return LandAround{make_synthetic_land(view), view.from, view.to};
}

DomeRequest standing_on_land(const Viewpoint& camera, DomeRequest sky) {
  constexpr double kEyes_m = 25.0;
  if (camera.projection != PanoramaProjection::fisheye)
    sky.altitude_m = std::max(sky.altitude_m, synthetic_height_m({0.0, 0.0}) + kEyes_m);
  return sky;
}

DomeScene scene_seen(const Viewpoint& camera, const DomeRequest& sky, const LandAround* land) {
  constexpr int kColumns = 24, kRows = 16;
  DomeScene scene = sky_scene(sky);
  std::optional<LandRayCaster> sight;
  if (land) sight.emplace(land->land, land->from, land->to);
  if (sight && sight->along(scene.sun, scene.altitude_m)) scene.sun_luminance = glm::dvec3(0.0);
  if (sky.exposure) return scene;
  const PanoramaView view = view_of(camera);
  const DomePainter painter(scene);
  double log_sum = 0.0, shares = 0.0;
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column) {
      const glm::dvec2 pixel((column + 0.5) / kColumns * view.width - 0.5, (row + 0.5) / kRows * view.height - 0.5);
      const double share = seen_share(view, pixel);
      log_sum += share * std::log(std::max(sky_text::luminance_of(sky_light_at(view, painter, scene.altitude_m,
                                                                               sight ? &*sight : nullptr, pixel)),
                                           1e-6));
      shares += share;
    }
  scene.exposure = exposure_for(std::exp(log_sum / shares)) * std::exp2(sky.exposure_ev);
  return scene;
}

Result<DomeDrawing> DomeDrawing::by_gpu() {
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  DomeDrawing drawing(std::move(*context));
  auto dome = DomeRenderer::create(*drawing.context_);
  if (!dome) return fail(dome.error());
  drawing.dome_.emplace(std::move(*dome));
  return drawing;
}

Result<Image<Rgb8>> DomeDrawing::draw(const PanoramaView& view, const DomeScene& scene, const LandAround* land) {
  if (!dome_) {
    std::optional<LandRayCaster> sight;
    if (land) sight.emplace(land->land, land->from, land->to);
    return sky_shown_picture(view, scene, sight ? &*sight : nullptr);
  }
  if (view.width != width_ || view.height != height_) {
    auto target = Offscreen::create(context_->info(), view.width, view.height);
    if (!target) return fail(target.error());
    target_.emplace(std::move(*target));
    width_ = view.width;
    height_ = view.height;
  }
  if (auto set = dome_->set(view, scene); !set) return fail(set.error());
  if (auto set = dome_->set_land(land ? land->land : DomeLand{}); !set) return fail(set.error());
  if (auto drawn = dome_->draw(target_->target()); !drawn) return fail(drawn.error());
  return target_->read();
}

}  // namespace kasumi
