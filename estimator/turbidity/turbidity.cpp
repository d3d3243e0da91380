#include "estimator/turbidity/turbidity.hpp"

#include <algorithm>
#include <cmath>

#include "estimator/turbidity/every_model.hpp"
#include "estimator/turbidity/own_sky.hpp"
#include "estimator/turbidity/sky_verdict.hpp"

namespace kasumi {

namespace {

constexpr double kClearSky = 0.80;          // from this share on the sky is called clear
constexpr double kNearlyAll = 0.97;         // share of samples that agree: a second draw would find the same
constexpr double kOutlierSigmas = 3.0;      // standard deviations of the first fit's residuals ...
constexpr double kSmallestOutlier = 0.004;  // ... and at least this much of ln Y, for elements that are not clear sky

// The sample nearest to the zenith: the part of the sky that is least likely to be obstructed (M Sect 3.4).
std::size_t nearest_to_zenith(std::span<const SkySample> samples) {
  return static_cast<std::size_t>(std::ranges::min_element(samples, {}, &SkySample::zenith) - samples.begin());
}

}  // namespace

SkyObservation SkyObserver::observe(const SkyPicture& picture, const SunDirection& sun,
                                    const EstimateOptions& options) {
  SkyObservation observation;
  TurbidityEstimate& estimate = observation.estimate;
  estimate.sun = sun;
  observation.sky = options.method == EstimateMethod::free_gain ? options.sky : SkyToFit{};
  const auto refuse = [&observation](const Refusal& refusal) -> SkyObservation {
    observation.estimate.usable = false;
    observation.estimate.sky = refusal.sky;
    observation.estimate.reason = refusal.reason;
    return std::move(observation);
  };
  if (const auto refusal = refuse_by_sun(sun, options)) return refuse(*refusal);

  if (!geometry_ || !geometry_->fits(picture)) geometry_ = sky_geometry(camera_, picture);
  SkyLight sky = sky_light(picture, *geometry_, camera_, sun, options.limits);
  const SkyStatistics statistics = statistics_of(picture, *geometry_, sky);
  if (const auto refusal = refuse_by_light(statistics, sun)) {
    observation.use = std::move(sky.use);
    return refuse(*refusal);
  }

  if (observation.sky.every_model || observation.sky.hosek) {
    const SkyLook look = options.mask_clouds ? look_of(picture, *geometry_, sky, sun) : SkyLook{};
    if (const auto refusal = refuse_by_look(look, statistics.brightest)) {
      std::ranges::replace(sky.use.elements(), PixelUse::clear, PixelUse::cloud);
      observation.use = std::move(sky.use);
      return refuse(*refusal);
    }
    SampleLimits nearer = options.limits;
    nearer.least_sun_distance = std::min(nearer.least_sun_distance, kNearestToSun);
    SkyEvidence evidence = observe_by_every_model(observation, sky_light(picture, *geometry_, camera_, sun, nearer),
                                                  statistics, picture, *geometry_, camera_, options);
    evidence.look = look;
    if (look.places >= kFewestPlaces) estimate.clear_fraction = std::min(estimate.clear_fraction, look.smooth);
    if (const auto refusal = refuse_by_evidence(evidence, options)) return refuse(*refusal);
    estimate.usable = true;
    estimate.sky = estimate.clear_fraction >= kClearSky ? SkyCondition::clear : SkyCondition::partly_cloudy;
    return observation;
  }

  const FittedSky fitted(observation.sky, sun);
  std::mt19937_64 random(options.seed);
  const auto draw_and_solve = [&] {
    observation.elements = draw_elements(sky, *geometry_, options.samples, random);
    observation.samples = samples_at(observation.elements, picture, *geometry_, sky, camera_, sun, options.limits);
    return options.method == EstimateMethod::free_gain || observation.samples.empty()
               ? solve_turbidity(observation.samples, options.solver, fitted)
               : solve_by_reference_pixel(observation.samples, nearest_to_zenith(observation.samples),
                                          options.reference);
  };
  double mask_clear = 1.0;
  if (options.mask_clouds)
    mask_clear = mask_clouds(sky, *geometry_, sun, options.clouds, observation.sky).clear_fraction;
  TurbiditySolution fit = draw_and_solve();
  // The fit itself shows what else is not clear sky, thin edges above all; repeated until hardly anything is found.
  constexpr int kRounds = 3;
  for (int round = 0;
       round < kRounds && options.mask_clouds && fit.solved && options.method == EstimateMethod::free_gain; ++round) {
    const double limit = std::max(kSmallestOutlier, kOutlierSigmas * fit.log_residual);
    mask_clear *= mask_outliers(sky, *geometry_, sun, fit.turbidity, fit.log_gain, limit, fitted);
    fit = draw_and_solve();
    if (fit.inliers > kNearlyAll * static_cast<double>(observation.samples.size())) break;
  }
  const RivalSkies rivals = compare_skies(observation.samples, fit, fitted);
  observation.use = std::move(sky.use);
  const int drawn = static_cast<int>(observation.samples.size());
  observation.inlier = fit.inlier;
  observation.log_gain = fit.log_gain;
  estimate.turbidity = fit.turbidity;
  estimate.sigma = fit.sigma;
  estimate.samples = fit.inliers;
  estimate.log_residual = fit.log_residual;
  estimate.clear_fraction = drawn > 0 ? mask_clear * fit.inliers / drawn : 0.0;

  if (const auto refusal = refuse_by_fit(fit, drawn, mask_clear, statistics.brightest, rivals, options))
    return refuse(*refusal);
  estimate.usable = true;
  estimate.sky = estimate.clear_fraction >= kClearSky ? SkyCondition::clear : SkyCondition::partly_cloudy;
  return observation;
}

std::optional<MeasuredSky> SkyObserver::measure(const SkyPicture& picture, const SkyObservation& observation,
                                                const Direction& through) {
  const TurbidityEstimate& estimate = observation.estimate;
  const bool clouds_known =
      estimate.usable || estimate.sky == SkyCondition::overcast || estimate.sky == SkyCondition::partly_cloudy;
  if (!clouds_known || observation.use.width() != picture.encoded.width() ||
      observation.use.height() != picture.encoded.height())
    return std::nullopt;
  if (!geometry_ || !geometry_->fits(picture)) geometry_ = sky_geometry(camera_, picture);
  const OwnSky own = own_sky(picture, *geometry_, camera_, observation.use, estimate.sun);
  return measure_sky(picture, *geometry_, camera_, own.use, estimate.sky, estimate.sun, through, own.uncovered_sun);
}

TurbidityEstimate estimate_turbidity(const SkyPicture& picture, const Camera& camera, const SunDirection& sun,
                                     const EstimateOptions& options) {
  return SkyObserver(camera).observe(picture, sun, options).estimate;
}

}  // namespace kasumi
