#include "estimator/turbidity/dome_log.hpp"

#include <algorithm>
#include <cmath>

#include "base/sky/dome_terms.hpp"
#include "estimator/sky/dome.hpp"

namespace kasumi {

namespace {

const double kFirst = std::log(kLowestTurbidity.value);
const double kStep = (std::log(kHighestDomeTurbidity.value) - kFirst) / (DomeLog::kNodes - 1);
constexpr double kDarkest = 1e-6;  // cd/m2: darker than any daytime sky

}  // namespace

DomeLog::DomeLog(double altitude_m, const SunDirection& sun) {
  for (std::size_t k = 0; k < kNodes; ++k)
    domes_[k] = dome(altitude_m, Turbidity{std::exp(kFirst + static_cast<double>(k) * kStep)}, sun);
}

DomeLog::Nodes DomeLog::at(double cos_zenith, double cos_sun_distance) const {
  const auto terms = dome_terms(domes_.front(), cos_zenith, cos_sun_distance);  // depends on the angles alone
  Nodes nodes{};
  for (std::size_t k = 0; k < kNodes; ++k) {
    double y = 0.0;
    for (std::size_t term = 0; term < terms.size(); ++term)
      y += terms[term] * static_cast<double>(domes_[k].coefficients[term].y);
    nodes[k] = static_cast<float>(std::log(std::max(y, kDarkest)));
  }
  return nodes;
}

DomeLog::Between DomeLog::between(Turbidity turbidity) {
  const double t = std::clamp(turbidity.value, kLowestTurbidity.value, kHighestDomeTurbidity.value);
  const double place = (std::log(t) - kFirst) / kStep;
  const auto left = static_cast<std::size_t>(std::clamp(place, 0.0, kNodes - 2.0));  // the interval's lower node
  const double u = place - static_cast<double>(left), u2 = u * u, u3 = u2 * u;
  std::array<double, 4> value{0.5 * (-u + 2.0 * u2 - u3), 0.5 * (2.0 - 5.0 * u2 + 3.0 * u3),
                              0.5 * (u + 4.0 * u2 - 3.0 * u3), 0.5 * (u3 - u2)};
  std::array<double, 4> slope{0.5 * (-1.0 + 4.0 * u - 3.0 * u2), 0.5 * (-10.0 * u + 9.0 * u2),
                              0.5 * (1.0 + 8.0 * u - 9.0 * u2), 0.5 * (3.0 * u2 - 2.0 * u)};
  for (double& s : slope) s /= t * kStep;
  if (left > 0 && left + 2 < kNodes) return {left - 1, value, slope};
  // A node beyond the end continues the parabola of the last three: 3, -3, 1.
  const bool low = left == 0;
  for (auto* weights : {&value, &slope}) {
    auto& w = *weights;
    w = low ? std::array<double, 4>{w[1] + 3.0 * w[0], w[2] - 3.0 * w[0], w[3] + w[0], 0.0}
            : std::array<double, 4>{0.0, w[0] + w[3], w[1] - 3.0 * w[3], w[2] + 3.0 * w[3]};
  }
  return {low ? 0 : kNodes - 4, value, slope};
}

}  // namespace kasumi
