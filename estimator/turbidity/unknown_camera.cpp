// The air by an unmeasured camera: an answer wherever its sigma is small enough to be useful.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "estimator/sky_fit/unknown_camera.hpp"
#include "estimator/turbidity/every_model.hpp"
#include "estimator/turbidity/picture_readings.hpp"
#include "estimator/turbidity/sky_verdict.hpp"
#include "estimator/turbidity/turbidity.hpp"

namespace kasumi {
namespace {

constexpr double kMostlyClear = 0.80;                    // from this share on the sky is called clear
constexpr Radians kNearestToBloom = from_degrees(15.0);  // an unknown lens scatters the sun's light that far
constexpr int kFewestReadings = 60;                      // as a tone curve needs
constexpr double kMostLeft = 0.30;                       // of ln light: no clear sky, whatever the camera

Refusal unknown(std::string reason) {
  return {SkyCondition::unknown, std::move(reason)};
}

// Elements that are not clear air by the picture's own colours count as cloud.
void keep_only(ElementLight& sky, const Image<std::uint8_t>& clear_air) {
  for (std::size_t i = 0; i < sky.use.elements().size(); ++i)
    if (auto& use = sky.use.elements()[i]; use == PixelUse::clear && clear_air.elements()[i] == 0)
      use = PixelUse::cloud;
}

double share_of_sky(const ElementLight& sky) {
  double clear = 0.0, all = 0.0;
  for (const PixelUse use : sky.use.elements()) {
    clear += use == PixelUse::clear;
    all += use == PixelUse::clear || use == PixelUse::cloud;
  }
  return all > 0.0 ? clear / all : 0.0;
}

std::optional<Refusal> refuse_by_what_is_left(const UncalibratedFit& fit, int readings) {
  if (readings < kFewestReadings || !fit.sky.solved)
    return unknown(fmt::format("{} places of clear sky are too few for an answer, expected at least {}", readings,
                               kFewestReadings));
  if (fit.log_residual > kMostLeft)
    return unknown(fmt::format("no clear sky is nearer than {:.0f} %, whatever the camera's tone curve and rim loss",
                               100.0 * fit.log_residual));
  return refuse_by_sigma(fit.sky.found.aerosol.aod_550, std::sqrt(fit.sky.found.covariance.aod_550));
}

}  // namespace

TurbidityObservation SkyObserver::observe_by_unknown_camera(const SkyPicture& picture, const SunDirection& sun,
                                                            const Image<std::uint8_t>& clear_air,
                                                            const CameraBelief& belief,
                                                            const EstimateParameters& options) {
  TurbidityObservation observation;
  TurbidityEstimate& estimate = observation.estimate;
  estimate.sun = sun;
  observation.sky = options.sky;
  const auto refuse = [&](const Refusal& refusal) {
    estimate.usable = false;
    estimate.sky = refusal.sky;
    estimate.reason = refusal.reason;
  };
  if (const auto refusal = refuse_by_sun(sun, options)) return refuse(*refusal), observation;
  if (!geometry_ || !geometry_->fits(picture)) geometry_ = sky_geometry(camera_, picture);
  SampleLimits limits = options.limits;
  limits.least_sun_distance = std::max(limits.least_sun_distance, kNearestToBloom);
  ElementLight sky = sky_light(picture, *geometry_, sun, limits);
  const auto by_light = refuse_by_light(statistics_of(picture, *geometry_, sky), sun);
  keep_only(sky, clear_air);
  estimate.clear_fraction = share_of_sky(sky);
  if (by_light) {
    observation.use = std::move(sky.use);
    return refuse(*by_light), observation;
  }

  std::mt19937_64 random(options.seed);
  ElementReadings drawn = readings_at(draw_elements(sky, *geometry_, options.samples, random), picture, *geometry_, sky,
                                      camera_, sun, limits);
  observation.elements = drawn.elements;
  observation.samples = samples_at(drawn.elements, picture, *geometry_, sky, camera_, sun, limits);
  observation.inlier.assign(observation.samples.size(), 1);
  observation.use = std::move(sky.use);
  const UncalibratedFit fit = fit_unknown_camera(drawn.readings, sun, options.sky, belief);
  estimate.samples = static_cast<int>(drawn.readings.size());
  estimate.log_residual = fit.log_residual;
  observation.readings = std::move(drawn.readings);
  observation.tone_exponent = fit.exponent;
  observation.sigma_tone_exponent = fit.sigma_exponent;
  observation.rim_loss = fit.rim_loss;
  observation.sigma_rim_loss = fit.sigma_rim_loss;
  if (fit.sky.solved) {
    observation.sky = followed(fit.sky, options.sky);
    observation.log_gain = fit.sky.models.front().log_luminance_gain;
    estimate.turbidity = fit.sky.turbidity;
    estimate.sigma = fit.sky.sigma_turbidity;
    estimate.found = fit.sky.found;
    for (const ModelFit& model : fit.sky.models) estimate.models.push_back(model.answer);
  }
  if (const auto refusal = refuse_by_what_is_left(fit, estimate.samples)) return refuse(*refusal), observation;
  estimate.usable = true;
  estimate.sky = estimate.clear_fraction >= kMostlyClear ? SkyCondition::clear : SkyCondition::partly_cloudy;
  return observation;
}

}  // namespace kasumi
