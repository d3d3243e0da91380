#include "estimator/turbidity/turbidity.hpp"

#include "estimator/turbidity/every_model.hpp"
#include "estimator/turbidity/one_model.hpp"
#include "estimator/turbidity/sky_verdict.hpp"
#include "estimator/turbidity/smooth_aureole.hpp"

namespace kasumi {

namespace {

constexpr double kClearSky = 0.80;  // from this share on the sky is called clear

}  // namespace

TurbidityObservation SkyObserver::observe(const SkyPicture& picture, const SunDirection& sun,
                                          const EstimateParameters& options) {
  TurbidityObservation observation;
  TurbidityEstimate& estimate = observation.estimate;
  estimate.sun = sun;
  observation.sky = options.sky;
  const auto refuse = [&observation](const Refusal& refusal) -> TurbidityObservation {
    observation.estimate.usable = false;
    observation.estimate.sky = refusal.sky;
    observation.estimate.reason = refusal.reason;
    return std::move(observation);
  };
  if (const auto refusal = refuse_by_sun(sun, options)) return refuse(*refusal);

  if (!geometry_ || !geometry_->fits(picture)) geometry_ = sky_geometry(camera_, picture);
  ElementLight sky = sky_light(picture, *geometry_, sun, options.limits);
  const ExposureStatistics statistics = statistics_of(picture, *geometry_, sky);
  if (const auto refusal = refuse_by_light(statistics, sun)) {
    observation.use = std::move(sky.use);
    return refuse(*refusal);
  }

  const bool every_model = options.sky.every_model || options.sky.hosek;
  const auto by = every_model ? observe_by_every_model : observe_by_one_model;
  const auto refusal = by(observation, std::move(sky), statistics, picture, *geometry_, camera_, options);
  if (refusal) return refuse(*refusal);
  estimate.usable = true;
  estimate.sky = estimate.clear_fraction >= kClearSky ? SkyCondition::clear : SkyCondition::partly_cloudy;
  return observation;
}

std::optional<MeasuredSky> SkyObserver::measure(const SkyPicture& picture, const TurbidityObservation& observation,
                                                const Direction& through) {
  const TurbidityEstimate& estimate = observation.estimate;
  const bool clouds_known =
      estimate.usable || estimate.sky == SkyCondition::overcast || estimate.sky == SkyCondition::partly_cloudy;
  if (!clouds_known || observation.use.width() != picture.encoded.width() ||
      observation.use.height() != picture.encoded.height())
    return std::nullopt;
  if (!geometry_ || !geometry_->fits(picture)) geometry_ = sky_geometry(camera_, picture);
  const SmoothAureole own = smooth_aureole(picture, *geometry_, camera_, observation.use, estimate.sun);
  return measure_sky(picture, *geometry_, camera_, own.use, estimate.sky, estimate.sun, through, own.uncovered_sun);
}

TurbidityEstimate estimate_turbidity(const SkyPicture& picture, const Camera& camera, const SunDirection& sun,
                                     const EstimateParameters& options) {
  return SkyObserver(camera).observe(picture, sun, options).estimate;
}

}  // namespace kasumi
