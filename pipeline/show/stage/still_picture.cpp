#include "pipeline/show/stage/still_picture.hpp"

#include <algorithm>
#include <cmath>

#include <spdlog/spdlog.h>
#include <glm/common.hpp>

#include "base/geometry.hpp"
#include "estimator/sky/sky_scene.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/offscreen.hpp"

namespace kasumi {
namespace {

// Smaller changes are invisible without a comparison with the previous picture.
const Radians kMinSunMove = from_degrees(0.4);
constexpr double kMinHazeChange = 0.05;         // of T - 1
constexpr double kMinCloudChange = 0.1;         // of the cloud cover's share
constexpr double kUsualFieldOfView_deg = 50.0;  // of a scene camera that is not calibrated

// The scene camera's view; for other lenses than pinholes, and for views too narrow to show more than one colour, a
// usual field of view instead.
PanoramaView view_of_sky(const Camera& scene, int width, int height) {
  const auto pinhole = scene.lens ? pinhole_model(*scene.lens) : std::nullopt;
  const double usual = 0.5 / std::tan(0.5 * from_degrees(kUsualFieldOfView_deg).value);
  const double focal = pinhole && scene.width > 0 ? pinhole->focal_px.x / scene.width : usual;
  return {PanoramaProjection::perspective, width, height, std::min(focal, 4.0 * usual) * width, scene.to_world};
}

// The curated picture was taken by day and does not change: its sky must darken at dusk more than it would for adapted
// eyes.
void dim(DomeScene& scene, const HemisphereSums& sums) {
  constexpr double kDay_cd_m2 = 3000.0, kLoss = 0.15;  // of the stops that the light loses
  scene.exposure *= std::pow(std::clamp(sums.mean_luminance / kDay_cd_m2, 1e-4, 1.0), kLoss);
}

// Blends in an overcast sky, grey and even, in proportion to the clouds.
void cover(DomeScene& scene, const HemisphereSums& sums, double clouds) {
  if (clouds <= 0.0) return;
  constexpr double kLevel = 0.55;  // of the clear sky's mean, which set the exposure
  const glm::dvec3 grey = kLevel * sums.mean_luminance * glm::dvec3(0.97, 1.0, 1.04);
  for (auto& coefficient : scene.sky.coefficients) coefficient *= static_cast<float>(1.0 - clouds);
  scene.sky.coefficients[0] += glm::vec3(clouds * grey);
  scene.sun_luminance *= clouds > 0.8 ? 0.0 : 1.0;
}

}  // namespace

std::optional<StillWeather> still_sky(const SkyReport& report) {
  const auto sky = report.estimate.sky;
  if (report.sun.source == SunSource::none || sky == SkyCondition::night) return std::nullopt;
  StillWeather found;
  found.sun = report.sun.direction;
  if (found.sun.z < -std::sin(from_degrees(6.0).value)) return std::nullopt;  // civil twilight has ended
  // Preetham's T stands for the same optical depth of haze here.
  if (const auto* air = report.seen_air()) found.turbidity = air->air.turbidity();
  if (sky == SkyCondition::overcast)
    found.clouds = 1.0;
  else if (sky == SkyCondition::partly_cloudy)
    found.clouds = std::clamp(1.0 - report.estimate.clear_fraction, 0.0, 1.0);
  return found;
}

Result<StillPicture> StillPicture::create(GlContext& context, const Content& content, const FlatTexels* texels) {
  StillPicture still(context);
  still.scene_ = content.config.installation.scene;
  still.altitude_m_ = content.config.installation.site.altitude_m;
  still.aerosol_ = content.config.installation.surroundings.air.to_be_found();
  auto background = FlatPicture::create(context, Image<Rgba8>(1, 1, kStillBackground));
  if (!background) return fail(background.error());
  still.background_ = std::move(*background);
  if (!content.still) return still;
  auto curated = texels && kLargestStill_px <= context.info().max_texture_size
                     ? FlatPicture::create(context, *texels)
                     : FlatPicture::create(context, *content.still);
  if (!curated) return fail(curated.error());
  still.curated_ = std::move(*curated);
  still.shows_sky_ = std::ranges::any_of(content.still->elements(), [](const Rgba8& pixel) { return pixel.a < 255; });
  return still;
}

bool StillPicture::holds(const DrawTarget& target, const StillWeather& sky) const {
  if (!with_sky_ || with_sky_->width != target.width || with_sky_->height != target.height) return false;
  const auto& drawn = with_sky_->sky;
  const double haze = sky.turbidity.value - 1.0, drawn_haze = drawn.turbidity.value - 1.0;
  return std::abs(haze - drawn_haze) <= kMinHazeChange * drawn_haze &&
         std::abs(sky.clouds - drawn.clouds) <= kMinCloudChange && angle_between(sky.sun, drawn.sun) <= kMinSunMove;
}

// Rendered offscreen into one picture, so that it can fade.
Result<> StillPicture::redraw(const DrawTarget& target, const StillWeather& sky) {
  if (!dome_) {
    auto dome = DomeRenderer::create(*context_);
    if (!dome) return fail(dome.error());
    dome_ = std::move(*dome);
  }
  // Software GL keeps the targets of all pictures that were ever in flight together.
  finish_gl();
  auto offscreen = Offscreen::create(context_->info(), target.width, target.height);
  if (!offscreen) return fail(offscreen.error());
  const DrawTarget whole = offscreen->target();
  const int width = curated_ ? curated_->width() : target.width, height = curated_ ? curated_->height() : target.height;
  const PanoramaView view = view_of_sky(scene_, width, height);
  DomeRequest request;
  request.altitude_m = altitude_m_;
  request.turbidity = sky.turbidity;
  request.like = aerosol_;
  request.sun = sky.sun;
  auto scene = sky_scene(request);
  const auto sums = sky_sums(DomePainter(scene));
  dim(scene, sums);
  cover(scene, sums, sky.clouds);
  clear_to(whole, glm::vec3(kStillBackground) / 255.0f);
  if (auto set = dome_->set(view, scene); !set) return set;
  if (auto drawn = dome_->draw(whole); !drawn) return drawn;
  if (curated_) {
    if (auto drawn = curated_->draw(whole, fitted(whole, width, height)); !drawn) return drawn;
  } else {
    // Plain land below the horizon, where that is in the picture.
    const Direction axis = view.camera_to_world * glm::dvec3(0.0, 0.0, 1.0);
    const double below = std::clamp(0.5 * height + view.focal_px * std::tan(std::asin(axis.z)), 0.0, 1.0 * height);
    const FlatPlace land{0.0, below, static_cast<double>(width), height - below};
    if (land.height > 0.0)
      if (auto drawn = background_->draw(whole, land); !drawn) return drawn;
  }
  auto picture = FlatPicture::create(*context_, std::move(*offscreen));
  if (!picture) return fail(picture.error());
  with_sky_ = ComposedStill{std::move(*picture), sky, target.width, target.height};
  finish_gl();
  return {};
}

Result<> StillPicture::draw_plain(const DrawTarget& target, double opacity) {
  if (auto drawn = background_->draw(target, everywhere(target), opacity); !drawn) return drawn;
  return curated_ ? curated_->draw(target, fitted(target, curated_->width(), curated_->height()), opacity) : Result<>{};
}

Result<> StillPicture::draw(const DrawTarget& target, const SkyReport& report, double opacity) {
  if (opacity <= 0.0) {
    with_sky_.reset();  // as large as the screen
    dome_.reset();      // some megabytes of programs and points
    return {};
  }
  const auto sky = shows_sky_ ? still_sky(report) : std::nullopt;
  if (!sky) return draw_plain(target, opacity);
  if (!holds(target, *sky))
    if (auto drawn = redraw(target, *sky); !drawn) {
      if (drawn.error().kind == FaultKind::device) return drawn;
      spdlog::warn("the sky of the still picture cannot be drawn: {}", drawn.error().message);
      shows_sky_ = false;
      return draw_plain(target, opacity);
    }
  return with_sky_->picture.draw(target, everywhere(target), opacity);
}

}  // namespace kasumi
