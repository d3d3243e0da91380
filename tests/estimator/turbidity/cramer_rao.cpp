#include "tests/estimator/turbidity/cramer_rao.hpp"

#include <cmath>
#include <limits>

namespace kasumi {

double cramer_rao_sigma(std::span<const LuminanceSample> samples, Turbidity turbidity, bool quantisation_only,
                        const FittedSky& sky) {
  // Information about T after fitting the gain: the weighted variance of d ln F / dT.
  double weight = 0.0, slope = 0.0, slope_squared = 0.0;
  FittedPlaces(samples, sky).at(turbidity, [&](std::size_t i, double, double s) {
    const auto sigma = static_cast<double>(quantisation_only ? samples[i].quantisation : samples[i].sigma);
    if (!(sigma > 0.0)) return;
    const double w = 1.0 / (sigma * sigma);
    weight += w;
    slope += w * s;
    slope_squared += w * s * s;
  });
  if (!(weight > 0.0)) return quantisation_only ? 0.0 : std::numeric_limits<double>::infinity();
  const double information = slope_squared - slope * slope / weight;
  return information > 0.0 ? 1.0 / std::sqrt(information) : std::numeric_limits<double>::infinity();
}

}  // namespace kasumi
