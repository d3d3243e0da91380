#include "estimator/turbidity/one_model.hpp"

#include <algorithm>

namespace kasumi {

namespace {

constexpr double kNearlyAll = 0.97;     // chosen: with fewer outliers than the rest another round is not worth its time
constexpr double kOutlierSigmas = 3.0;  // standard deviations of the first fit's residuals ...
constexpr double kSmallestOutlier = 0.004;  // ... and at least this much of ln Y, for elements that are not clear sky

}  // namespace

std::optional<Refusal> observe_by_one_model(TurbidityObservation& observation, ElementLight sky,
                                            const ExposureStatistics& statistics, const SkyPicture& picture,
                                            const ElementGeometry& geometry, const Camera& camera,
                                            const EstimateParameters& options) {
  TurbidityEstimate& estimate = observation.estimate;
  const SunDirection& sun = estimate.sun;
  const FittedSky fitted(observation.sky, sun);
  std::mt19937_64 random(options.seed);
  const auto draw_and_solve = [&] {
    observation.elements = draw_elements(sky, geometry, options.samples, random);
    observation.samples = samples_at(observation.elements, picture, geometry, sky, camera, sun, options.limits);
    return options.solve && !observation.samples.empty() ? options.solve(observation.samples)
                                                         : solve_turbidity(observation.samples, options.solver, fitted);
  };
  double mask_clear = 1.0;
  if (options.mask_clouds) mask_clear = mask_clouds(sky, geometry, sun, options.clouds, observation.sky).clear_fraction;
  TurbiditySolution fit = draw_and_solve();
  // The fit itself shows what else is not clear sky, thin edges above all; repeated until hardly anything is found.
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds && options.mask_clouds && fit.solved && !options.solve; ++round) {
    const double limit = std::max(kSmallestOutlier, kOutlierSigmas * fit.log_residual);
    mask_clear *= mask_outliers(sky, geometry, sun, fit.turbidity, fit.log_gain, limit, fitted);
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
  return refuse_by_fit(fit, drawn, mask_clear, statistics.brightest, rivals, options);
}

}  // namespace kasumi
