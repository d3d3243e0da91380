#include "pipeline/sky/sky_drawing.hpp"

#include <algorithm>
#include <cmath>

#include "base/earth.hpp"

namespace kasumi {

SkyView view_of(const SkyCamera& camera) {
  SkyView view{camera.projection, camera.width, camera.height, 0.0, glm::dmat3(1.0)};
  const Radians heading = from_degrees(camera.heading_deg), level{0.0};
  switch (camera.projection) {
    case SkyProjection::perspective:
      view.focal_px = 0.5 * camera.width / std::tan(0.5 * from_degrees(camera.field_of_view_deg).value);
      view.camera_to_world = camera_to_world(heading, from_degrees(camera.pitch_deg), level);
      break;
    case SkyProjection::fisheye:
      view.focal_px = std::min(camera.width, camera.height) / kPi;
      view.camera_to_world = camera_to_world(heading + Radians{kPi}, from_degrees(90.0), level);
      break;
    case SkyProjection::equirectangular:
      view.focal_px = camera.width / (2.0 * kPi);
      view.camera_to_world = camera_to_world(heading, level, level);
      break;
  }
  return view;
}

std::optional<LandAround> land_for(const SkyCamera& camera, double observer_m, bool mountains) {
  if (camera.projection == SkyProjection::fisheye) return std::nullopt;
  constexpr double kHighestPeak_m = 3600.0;
  // A full circle has its seam behind the camera.
  double half = kPi - 1e-4;
  if (camera.projection == SkyProjection::perspective) {
    const double steepest =
        std::abs(from_degrees(camera.pitch_deg).value) +
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
  view.rings = mountains ? 640 : 160;
  view.nearest_m = 1.0;
  const auto to_horizon = [](double h) { return std::sqrt(2.0 * kEarthRadius_m * std::max(h, 1.0)); };
  view.farthest_m = 1.02 * (to_horizon(observer_m) + (mountains ? to_horizon(0.5 * kHighestPeak_m) : 0.0));
  return LandAround{make_synthetic_land(view), view.from, view.to};
}

SkyRequest standing_on_land(const SkyCamera& camera, SkyRequest sky) {
  constexpr double kEyes_m = 25.0;
  if (camera.projection != SkyProjection::fisheye)
    sky.altitude_m = std::max(sky.altitude_m, synthetic_height_m({0.0, 0.0}) + kEyes_m);
  return sky;
}

Result<SkyDrawing> SkyDrawing::by_gpu() {
  auto context = open_headless_context();
  if (!context) return fail(context.error());
  SkyDrawing drawing(std::move(*context));
  auto dome = DomeRenderer::create(*drawing.context_);
  if (!dome) return fail(dome.error());
  drawing.dome_.emplace(std::move(*dome));
  return drawing;
}

Result<Image<Rgb8>> SkyDrawing::draw(const SkyView& view, const SkyScene& scene, const LandAround* land) {
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
