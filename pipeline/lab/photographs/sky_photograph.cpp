#include "pipeline/lab/photographs/sky_photograph.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/earth.hpp"
#include "calib/light/merged_exposures.hpp"
#include "calib/mask/square_pixels.hpp"
#include "estimator/sky/sun.hpp"
#include "estimator/turbidity/sky_picture.hpp"
#include "estimator/turbidity/sky_verdict.hpp"
#include "pipeline/lab/photographs/found_air.hpp"
#include "pipeline/site/files/small_photograph.hpp"

namespace kasumi {

namespace {

bool same(const std::optional<ImageCircle>& a, const ImageCircle& b) {
  return a && a->centre == b.centre && a->radius_px == b.radius_px;
}

constexpr double kSigmaOfKnownTone = 0.02, kSigmaOfKnownRim = 0.05;
constexpr double kOtherPlace_m = 25'000.0;  // the sun stands .2 deg elsewhere
constexpr double kNightByTime = 0.99;       // one clock in a hundred is half a day off
constexpr double kSurelyClosed = 0.97;      // cloud fraction; overcast is from .93 on
constexpr int kFirstSamples = 200;          // more than are independent: whether a sky is closed needs no more
constexpr const char* kNotLookedFor = "; not looked for in the picture";
constexpr Radians kWrongSun = from_degrees(15.0);  // seen so far from where it is given: that is not the sky's sun

double distance_m(const Site& site, double latitude_deg, double longitude_deg) {
  const auto on_sphere = [](double latitude, double longitude) {
    return direction_from(from_degrees(90.0 - latitude), from_degrees(longitude));
  };
  const auto apart =
      angle_between(on_sphere(site.latitude_deg, site.longitude_deg), on_sphere(latitude_deg, longitude_deg));
  return kEarthRadius_m * apart.value;
}

ImageCircle in_own_pixels(ImageCircle circle, double pixel_aspect) {
  circle.centre.x /= pixel_aspect;
  return circle;
}

// Of means over the pixels of kSmallPhotographShrink, as many of them as a first look needs.
SkyPicture coarse_picture(Image<glm::vec3> encoded) {
  constexpr int kLargestSide = 160;  // elements: a degree of the sky
  SkyPicture picture;
  const int step = (std::max(encoded.width(), encoded.height()) + kLargestSide - 1) / kLargestSide;
  const int offset = (step - 1) / 2;
  picture.step = kSmallPhotographShrink * step;
  picture.first = glm::dvec2{kSmallPhotographShrink * offset + 0.5 * (kSmallPhotographShrink - 1)};
  picture.quantum = 1.0 / 255.0;
  if (step == 1) {
    picture.encoded = std::move(encoded);
    return picture;
  }
  picture.encoded =
      Image<glm::vec3>((encoded.width() - offset + step - 1) / step, (encoded.height() - offset + step - 1) / step);
  for (int y = 0; y < picture.encoded.height(); ++y)
    for (int x = 0; x < picture.encoded.width(); ++x)
      picture.encoded.at(x, y) = encoded.at(offset + x * step, offset + y * step);
  return picture;
}

// Refusals that depend on where in the picture the sun is.
bool asked_the_sky(SkyCondition sky) {
  return sky != SkyCondition::night && sky != SkyCondition::sun_too_low && sky != SkyCondition::covered_lens;
}

}  // namespace

void PhotographEstimator::place(PhotographReport& report, std::optional<Utc> utc) const {
  report.utc = utc ? utc : options_.utc;
  report.site = options_.site;
  const auto& place = report.taken.place;
  if (options_.site && place) {
    const double off_m = distance_m(*options_.site, place->latitude_deg, place->longitude_deg);
    if (off_m > kOtherPlace_m) report.off_m = off_m;
  }
  if (options_.sun) return;
  report.utc_by_file = !report.utc && report.taken.utc;
  if (report.utc_by_file) report.utc = report.taken.utc;
  report.site_by_file = !report.site && place;
  if (!report.site_by_file) return;
  const double altitude_m = options_.estimate.sky.altitude_m;
  report.site = Site{"", place->latitude_deg, place->longitude_deg,
                     options_.altitude_given ? altitude_m : place->altitude_m.value_or(altitude_m)};
}

double PhotographEstimator::altitude_m(const PhotographReport& report) const {
  if (report.site) return report.site->altitude_m;
  // One model alone answers as it always did: for the sea's level.
  return options_.estimate.sky.every_model ? options_.estimate.sky.altitude_m : 0.0;
}

Camera PhotographEstimator::ideal_camera(const Image<glm::vec3>& picture, const ImageCircle& circle,
                                         const AzimuthFit* turn) const {
  Camera camera;
  camera.name = "sky";
  camera.width = picture.width();
  camera.height = picture.height();
  const Radians edge = 0.5 * options_.field_of_view.value_or(from_degrees(180.0));
  camera.lens = options_.equisolid
                    ? equisolid_lens(circle.centre, circle.radius_px / (2.0 * std::sin(0.5 * edge.value)), edge)
                    : equidistant_lens(circle.centre, circle.radius_px / edge.value, edge);
  if (turn && turn->mirrored) camera.lens = mirrored_lens(camera.lens);
  const Radians up = options_.azimuth_up.value_or(turn ? turn->azimuth_up : Radians{});
  camera.to_world = camera_to_world(up - from_degrees(180.0), from_degrees(90.0), Radians{0.0});
  camera.response = options_.linear_response ? Response::linear() : Response::srgb();
  if (options_.tone) camera.response = corrected(camera.response, options_.tone->exponent);
  if (options_.rim_loss) camera.vignetting = {circle.centre, circle.radius_px, {-*options_.rim_loss, 0.0, 0.0}};
  return camera;
}

EstimateParameters PhotographEstimator::estimate_options(const PhotographReport& report) const {
  auto options = options_.estimate;
  if (report.site_by_file) options.sky.altitude_m = report.site->altitude_m;
  return options;
}

SunGiven PhotographEstimator::sun_given(const PhotographReport& report, const AzimuthFit* turn) const {
  SunGiven given;
  given.from_picture = options_.sun_from_image;
  given.unknown_camera = !options_.calibrated;
  given.orientation_known = options_.calibrated || options_.azimuth_up || turn;
  given.azimuth_up = options_.azimuth_up.value_or(turn ? turn->azimuth_up : Radians{});
  given.direction = options_.sun;
  given.by = "as given";
  if (!given.direction && report.utc && report.site) {
    given.direction = sun_position(*report.utc, *report.site).direction;
    given.by = "by time and place";
  }
  return given;
}

SizedCircle PhotographEstimator::circle_alone(const std::filesystem::path& file, const Photograph& photograph) const {
  SizedCircle alone{photograph.encoded.width(), photograph.encoded.height(), std::nullopt};
  if (options_.circle)
    alone.found = FoundCircle{*options_.circle, 1.0, {}, 1.0, {}};
  else if (const auto* before = options_.memory ? options_.memory->found_in(file) : nullptr)
    alone = *before;
  else
    alone.found = find_image_circle(to_rgb8(photograph));
  return alone;
}

Result<SizedCircle> PhotographEstimator::circle_in(const std::filesystem::path& file) const {
  std::string damage;
  const auto photograph = read_photograph(file, options_.allow_damaged ? &damage : nullptr);
  if (!photograph) return fail(photograph.error());
  return circle_alone(file, *photograph);
}

std::optional<ImageCircle> PhotographEstimator::placed_circle(const std::filesystem::path& file, Photograph& photograph,
                                                              PhotographReport& report) const {
  report.camera_circle = circle_alone(file, photograph);
  auto& found = report.camera_circle.found;
  if (options_.memory && !options_.circle) found = options_.memory->circle_of(report.camera_circle);
  if (!found) return std::nullopt;
  report.circle_confidence = found->confidence;
  report.pixel_aspect = found->pixel_aspect;
  report.circle = in_own_pixels(found->circle, found->pixel_aspect);
  if (found->horizon) report.horizon_circle = in_own_pixels(*found->horizon, found->pixel_aspect);
  photograph.encoded = with_square_pixels(std::move(photograph.encoded), found->pixel_aspect);
  // The horizon is 90 deg off the axis, whatever the lens' field of view.
  return found->horizon && !options_.field_of_view ? found->horizon : found->circle;
}

const RememberedCamera* PhotographEstimator::remembered(const PhotographReport& report) const {
  const auto& [width, height, found] = report.camera_circle;
  return options_.memory && found ? options_.memory->camera_of(width, height, found->circle) : nullptr;
}

void PhotographEstimator::observe_by_unknown_camera(const std::filesystem::path& file, const SkyPicture& picture,
                                                    PhotographReport& report) {
  auto& estimate = report.look.estimate;
  if (report.cover.sky == CoverClass::overcast || report.cover.sky == CoverClass::night || !report.cover.fraction) {
    estimate.sky = report.cover.sky == CoverClass::overcast ? SkyCondition::overcast
                   : report.cover.sky == CoverClass::night  ? SkyCondition::night
                                                            : SkyCondition::unknown;
    estimate.reason = report.cover.fraction ? fmt::format("{}: {:.0f} % of the sky is cloud", name_of(report.cover.sky),
                                                          100.0 * *report.cover.fraction)
                                            : report.cover.reason;
    return;
  }
  const auto* known = remembered(report);
  CameraBelief belief = known ? CameraMemory::belief_beside(*known, file) : CameraBelief{};
  if (options_.tone_exponent) {
    belief.log_exponent = std::log(*options_.tone_exponent);
    belief.sigma_log_exponent = kSigmaOfKnownTone;
  }
  const bool altitude_by_file = report.site_by_file && report.taken.place->altitude_m;
  belief.sigma_altitude_m = altitude_by_file ? 0.0 : options_.sigma_altitude_m;
  if (options_.rim_loss) belief.rim_loss = kSigmaOfKnownRim;
  report.look = observer_->observe_by_unknown_camera(picture, report.sun.in_camera, clear_air_of(report.cover), belief,
                                                     estimate_options(report));
  if (report.look.tone_exponent > 0.0)
    report.tone = ToneCurve{report.look.tone_exponent, report.look.sigma_tone_exponent, estimate.log_residual,
                            known ? known->tones + (known->told.contains(file) ? 0 : 1) : 1};
}

bool PhotographEstimator::answer_by_night(const SunGiven& given, PhotographReport& report) const {
  if (given.from_picture || !given.direction) return false;
  const auto refused = refuse_by_sun(*given.direction, estimate_options(report));
  if (!refused || refused->sky != SkyCondition::night) return false;
  report.look.estimate.sky = refused->sky;
  report.look.estimate.reason = report.cover.reason = refused->reason;
  report.cover.sky = CoverClass::night;
  report.cover.confidence = kNightByTime;
  report.sun.direction = report.sun.by_time_and_place = given.direction;
  report.sun.in_camera = *given.direction;
  report.sun.azimuth_up = given.azimuth_up;
  report.sun.told = given.by + kNotLookedFor;
  return true;
}

std::optional<PhotographEstimator::FirstAnswer> PhotographEstimator::by_first_look(const std::filesystem::path& file,
                                                                                   std::optional<Utc> utc) {
  if (!options_.calibrated || !options_.first_look || options_.sun_from_image) return std::nullopt;
  const Camera& camera = *options_.calibrated;
  auto small = read_small_photograph(file);
  if (!small || small->width != camera.width || small->height != camera.height) return std::nullopt;
  FirstAnswer answer;
  PhotographReport& report = answer.report;
  report.taken = small->taken;
  report.tone = options_.tone;
  place(report, utc);
  const SunGiven given = sun_given(report, nullptr);
  if (answer_by_night(given, report)) return answer;
  if (!given.direction) return std::nullopt;

  const SkyPicture coarse = coarse_picture(std::move(small->encoded));
  if (!first_look_) first_look_.emplace(camera);
  const auto closed_sky = first_look_->refuse(coarse, *given.direction, estimate_options(report));
  if (!closed_sky) return std::nullopt;
  answer.sun_may_show = closed_sky->sun_may_show;
  report.cover = cloud_cover(coarse, camera, given.direction, first_directions_, kFirstSamples);
  const bool closed = report.cover.sky == CoverClass::overcast && report.cover.fraction > kSurelyClosed;
  if (closed_sky->refusal.sky == SkyCondition::overcast && !closed) return std::nullopt;
  auto& estimate = report.look.estimate;
  estimate.sun = *given.direction;
  estimate.sky = closed_sky->refusal.sky;
  estimate.reason = closed_sky->refusal.reason;
  report.look.sky = estimate_options(report).sky;
  report.sun.direction = report.sun.by_time_and_place = given.direction;
  report.sun.in_camera = *given.direction;
  report.sun.azimuth_up = given.azimuth_up;
  report.sun.told = given.by + kNotLookedFor;
  report.picture = coarse;
  return answer;
}

Result<PhotographReport> PhotographEstimator::estimate_from(const std::filesystem::path& file, std::optional<Utc> utc) {
  auto first = by_first_look(file, utc);
  if (first && !first->sun_may_show) return std::move(first->report);
  PhotographReport report;
  auto photograph = read_photograph(file, options_.allow_damaged ? &report.damage : nullptr, &report.taken);
  if (!photograph) return fail(photograph.error());
  if (first) {
    const auto whole = sky_picture(photograph->encoded, photograph->quantum, *options_.calibrated);
    if (whole && !first_look_->shows_sun(*whole, first->report.sun.in_camera)) return std::move(first->report);
  }
  return estimate_of(file, std::move(*photograph), std::move(report), utc);
}

std::optional<PhotographReport> PhotographEstimator::estimate_from_stack(
    const std::vector<std::filesystem::path>& files, std::optional<Utc> utc) {
  PhotographReport report;
  std::vector<Photograph> exposures;
  for (const auto& file : files) {
    TakenAt taken;
    auto photograph = read_photograph(file, nullptr, &taken);  // whole ones alone: there are others
    if (!photograph) continue;
    if (report.stack.empty()) report.taken = taken;
    exposures.push_back(std::move(*photograph));
    report.stack.push_back(file);
  }
  auto response = options_.linear_response ? Response::linear() : Response::srgb();
  if (options_.calibrated) response = options_.calibrated->response;
  auto merged = merge_exposures(exposures, response);
  if (!merged) return std::nullopt;
  report.exposure_ratios = std::move(merged->ratios);
  const auto first = report.stack.front();
  auto answer = estimate_of(first, std::move(merged->picture), std::move(report), utc);
  return answer ? std::optional(std::move(*answer)) : std::nullopt;
}

Result<PhotographReport> PhotographEstimator::estimate_of(const std::filesystem::path& file, Photograph photograph,
                                                          PhotographReport report, std::optional<Utc> utc) {
  report.tone = options_.tone;
  place(report, utc);
  auto& estimate = report.look.estimate;
  const AzimuthFit* turn = nullptr;

  if (options_.calibrated) {
    if (!observer_) observer_.emplace(*options_.calibrated);
  } else {
    const auto circle = placed_circle(file, photograph, report);
    if (!circle) {
      estimate.reason = report.cover.reason = "no image circle is seen: no picture of a fisheye";
      return report;
    }
    if (report.circle_confidence < kLeastCircleConfidence) {
      estimate.reason = report.cover.reason = fmt::format(
          "no sky through a fisheye: the likeliest image circle is right with {:.1f} % only; give it with "
          "--circle CX,CY,R",
          100.0 * report.circle_confidence);
      return report;
    }
    if (const auto* known = remembered(report); known && known->turn && !options_.azimuth_up) turn = &*known->turn;
    report.mirrored = turn && turn->mirrored;
    const auto& picture = photograph.encoded;
    const bool same_camera = observer_ && same(observed_circle_, *circle) &&
                             observer_->camera().width == picture.width() &&
                             observer_->camera().height == picture.height();
    if (!same_camera) {
      observer_.emplace(ideal_camera(picture, *circle, turn));
      directions_.reset();
    }
    observed_circle_ = circle;
  }

  // A camera that is known has days by which a wrong clock is noticed: by night nothing of its picture is asked.
  if ((options_.calibrated || options_.memory) && answer_by_night(sun_given(report, turn), report)) return report;

  auto picture = sky_picture(photograph.encoded, photograph.quantum, observer_->camera());
  if (!picture) return fail(FaultKind::bad_input, "{}: {}", file.string(), picture.error().message);

  report.sun = find_photographed_sun(*picture, observer_->camera(), sun_given(report, turn));
  if (turn) {
    report.sun.orientation = Orientation::from_series;
    report.sun.orientation_told =
        fmt::format("by {} suns of this camera{}", turn->suns, turn->mirrored ? "; its pictures are mirrored" : "") +
        (report.sun.orientation_told.empty() ? "" : "; " + report.sun.orientation_told);
  }
  report.cover = cloud_cover(*picture, observer_->camera(),
                             report.sun.direction ? std::optional(report.sun.in_camera) : std::nullopt, directions_);
  if (!report.sun.direction) {
    estimate.reason = "no sun is seen in the picture: give its position, or time and place";
    return report;
  }
  if (options_.unknown_camera && !options_.calibrated)
    observe_by_unknown_camera(file, *picture, report);
  else
    report.look = observer_->observe(*picture, report.sun.in_camera, estimate_options(report));
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
    report.quality = air_quality(*report.air, altitude_m(report));
  }
  return report;
}

}  // namespace kasumi
