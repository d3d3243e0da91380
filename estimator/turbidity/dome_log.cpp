#include "estimator/turbidity/dome_log.hpp"

#include <algorithm>
#include <cmath>

#include "base/sky/dome_terms.hpp"
#include "estimator/sky/dome.hpp"

namespace kasumi {

namespace {

constexpr double kDarkest = 1e-6;  // cd/m2: darker than any daytime sky
// With an aerosol given T goes down to where there is almost none (an optical depth of .003); the shift keeps the nodes
// dense there, where the sky changes fastest.
constexpr Turbidity kAlmostNoAerosol{1.02};
constexpr double kShiftToNoAerosol = 0.5;

}  // namespace

DomeLog::DomeLog(double altitude_m, const SunDirection& sun, const std::optional<Aerosol>& like)
    : lowest_(like ? kAlmostNoAerosol : kLowestTurbidity), highest_(kHighestDomeTurbidity) {
  if (like) {
    Aerosol haziest = *like;
    haziest.aod_550 = kHighestDomeAod;
    highest_ = std::min(Turbidity{turbidity_of(haziest)}, kHighestTurbidity);
    shift_ = kShiftToNoAerosol;
  }
  // A node more at each end, where there is such a dome: slopes at the ends are as exact as elsewhere.
  const int beyond = like ? 0 : 1;
  first_ = std::log(lowest_.value - shift_);
  step_ = (std::log(highest_.value - shift_) - first_) / (kNodes - 1 - 2 * beyond);
  first_ -= beyond * step_;
  for (std::size_t k = 0; k < kNodes; ++k)
    domes_[k] = like ? dome(altitude_m, aerosol_of(node(k).value, like->angstrom_exponent, like->kind), sun)
                     : dome(altitude_m, node(k), sun);
}

Turbidity DomeLog::node(std::size_t k) const {
  return {shift_ + std::exp(first_ + static_cast<double>(k) * step_)};
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

DomeLog::Between DomeLog::between(Turbidity turbidity) const {
  const double t = std::clamp(turbidity.value, lowest_.value, highest_.value) - shift_;
  const double place = (std::log(t) - first_) / step_;
  const auto left = static_cast<std::size_t>(std::clamp(place, 0.0, kNodes - 2.0));  // the interval's lower node
  const double u = place - static_cast<double>(left), u2 = u * u, u3 = u2 * u;
  std::array<double, 4> value{0.5 * (-u + 2.0 * u2 - u3), 0.5 * (2.0 - 5.0 * u2 + 3.0 * u3),
                              0.5 * (u + 4.0 * u2 - 3.0 * u3), 0.5 * (u3 - u2)};
  std::array<double, 4> slope{0.5 * (-1.0 + 4.0 * u - 3.0 * u2), 0.5 * (-10.0 * u + 9.0 * u2),
                              0.5 * (1.0 + 8.0 * u - 9.0 * u2), 0.5 * (3.0 * u2 - 2.0 * u)};
  for (double& s : slope) s /= t * step_;
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
