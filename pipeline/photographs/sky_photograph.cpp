#include "pipeline/photographs/sky_photograph.hpp"

#include <cmath>

#include "estimator/given_air.hpp"
#include "estimator/sky/sun.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

namespace {

constexpr double kAltitudeUnknown_m = 0.0;

bool same(const std::optional<ImageCircle>& a, const ImageCircle& b) {
  return a && a->centre == b.centre && a->radius_px == b.radius_px;
}

}  // namespace

Camera SkyPhotographs::ideal_camera(const Image<glm::vec3>& picture, const ImageCircle& circle) const {
  Camera camera;
  camera.name = "sky";
  camera.width = picture.width();
  camera.height = picture.height();
  const Radians edge = 0.5 * options_.field_of_view;
  camera.lens = options_.equisolid
                    ? equisolid_lens(circle.centre, circle.radius_px / (2.0 * std::sin(0.5 * edge.value)), edge)
                    : equidistant_lens(circle.centre, circle.radius_px / edge.value, edge);
  camera.to_world = camera_to_world(options_.azimuth_up - from_degrees(180.0), from_degrees(90.0), Radians{0.0});
  camera.response = options_.linear_response ? Response::linear() : Response::srgb();
  return camera;
}

Result<SkyPhotographReport> SkyPhotographs::estimate_from(const std::filesystem::path& file, std::optional<Utc> utc) {
  const auto photograph = read_photograph(file);
  if (!photograph) return fail(photograph.error());
  SkyPhotographReport report;

  if (options_.calibrated) {
    if (!observer_) observer_.emplace(*options_.calibrated);
  } else {
    report.circle = options_.circle ? options_.circle : find_image_circle(to_rgb8(*photograph));
    if (!report.circle) {
      report.look.estimate.reason = "no image circle was found: give it with --circle CX,CY,R";
      return report;
    }
    const auto& picture = photograph->encoded;
    const bool same_camera = observer_ && same(observed_circle_, *report.circle) &&
                             observer_->camera().width == picture.width() &&
                             observer_->camera().height == picture.height();
    if (!same_camera) observer_.emplace(ideal_camera(picture, *report.circle));
    observed_circle_ = report.circle;
  }

  auto picture = sky_picture(photograph->encoded, photograph->quantum, observer_->camera());
  if (!picture) return fail(FaultKind::bad_input, "{}: {}", file.string(), picture.error().message);

  if (!utc) utc = options_.utc;
  std::optional<SunDirection> given = options_.sun;
  if (!given && utc && options_.site) given = sun_position(*utc, *options_.site).direction;
  const auto sun =
      cross_check(given, options_.sun_from_image || !given ? find_sun(*picture, observer_->camera()) : std::nullopt,
                  /*clock_trusted=*/given.has_value() && !options_.sun_from_image);
  report.sun_source = sun.message;
  if (sun.source == SunSource::none) {
    report.look.estimate.reason = "the sun was not found in the image: give its position, or time and site";
    return report;
  }
  report.sun = sun.direction;
  report.look = observer_->observe(*picture, sun.direction, options_.estimate);
  report.picture = std::move(*picture);
  if (report.look.estimate.usable)
    report.air = air_quality(air_of(report.look.estimate.turbidity, report.look.sky.aerosol),
                             options_.site ? options_.site->altitude_m : kAltitudeUnknown_m);
  return report;
}

}  // namespace kasumi
