#include "pipeline/photographs/sky_photograph.hpp"

#include <cmath>

#include "estimator/sky/sun.hpp"
#include "estimator/turbidity/sky_picture.hpp"
#include "pipeline/photographs/found_air.hpp"

namespace kasumi {

namespace {

bool same(const std::optional<ImageCircle>& a, const ImageCircle& b) {
  return a && a->centre == b.centre && a->radius_px == b.radius_px;
}

constexpr Radians kWrongSun = from_degrees(15.0);  // seen so far from where it is given: that is not the sky's sun

// Refusals that depend on where in the picture the sun is.
bool asked_the_sky(SkyCondition sky) {
  return sky != SkyCondition::night && sky != SkyCondition::sun_too_low && sky != SkyCondition::covered_lens;
}

}  // namespace

double SkyPhotographs::altitude_m() const {
  if (options_.site) return options_.site->altitude_m;
  // One model alone answers as it always did: for the sea's level.
  return options_.estimate.sky.every_model ? options_.estimate.sky.altitude_m : 0.0;
}

Camera SkyPhotographs::ideal_camera(const Image<glm::vec3>& picture, const ImageCircle& circle) const {
  Camera camera;
  camera.name = "sky";
  camera.width = picture.width();
  camera.height = picture.height();
  const Radians edge = 0.5 * options_.field_of_view;
  camera.lens = options_.equisolid
                    ? equisolid_lens(circle.centre, circle.radius_px / (2.0 * std::sin(0.5 * edge.value)), edge)
                    : equidistant_lens(circle.centre, circle.radius_px / edge.value, edge);
  camera.to_world =
      camera_to_world(options_.azimuth_up.value_or(Radians{}) - from_degrees(180.0), from_degrees(90.0), Radians{0.0});
  camera.response = options_.linear_response ? Response::linear() : Response::srgb();
  if (options_.tone) camera.response = corrected(camera.response, options_.tone->exponent);
  return camera;
}

SunGiven SkyPhotographs::sun_given(const std::optional<Utc>& utc) const {
  SunGiven given;
  given.from_picture = options_.sun_from_image;
  given.orientation_known = options_.calibrated || options_.azimuth_up;
  given.azimuth_up = options_.azimuth_up.value_or(Radians{});
  given.direction = options_.sun;
  given.by = "as given";
  if (!given.direction && utc && options_.site) {
    given.direction = sun_position(*utc, *options_.site).direction;
    given.by = "by time and place";
  }
  return given;
}

Result<SkyPhotographReport> SkyPhotographs::estimate_from(const std::filesystem::path& file, std::optional<Utc> utc) {
  SkyPhotographReport report;
  const auto photograph = read_photograph(file, options_.allow_damaged ? &report.damage : nullptr);
  if (!photograph) return fail(photograph.error());
  report.tone = options_.tone;

  if (options_.calibrated) {
    if (!observer_) observer_.emplace(*options_.calibrated);
  } else {
    report.circle = options_.circle ? options_.circle : find_image_circle(to_rgb8(*photograph));
    if (!report.circle) {
      report.look.estimate.reason = "no image circle was found with certainty: give it with --circle CX,CY,R";
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

  report.sun = find_photographed_sun(*picture, observer_->camera(), sun_given(utc ? utc : options_.utc));
  auto& estimate = report.look.estimate;
  if (!report.sun.direction) {
    estimate.reason = "the sun was not found in the image with certainty: give its position, or time and site";
    return report;
  }
  report.look = observer_->observe(*picture, report.sun.in_camera, options_.estimate);
  if (!report.sun.doubt.empty()) {
    if (estimate.usable && report.sun.disagreement > kWrongSun) {
      estimate.usable = false;  // whatever fits a sun that is elsewhere
      estimate.reason = "rejected: " + report.sun.doubt;
    } else if (!estimate.usable && asked_the_sky(estimate.sky)) {
      estimate.reason = report.sun.doubt + "; " + estimate.reason;
    }
  }
  report.picture = std::move(*picture);
  if (estimate.usable) {
    report.air = found_air(estimate, report.look.sky);
    report.quality = air_quality(*report.air, altitude_m());
  }
  return report;
}

}  // namespace kasumi
