// Shared by the two methods for the response curve.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace kasumi {

// Scales the curve to rise from 0 to 1, and levels small dips that noise causes. False: not a response curve (not
// finite, or clearly falling).
inline bool make_curve(std::vector<double>& light) {
  const double last = light.back();
  if (!(last > 0.0) || !std::isfinite(last)) return false;
  double fallen = 0.0;
  light.front() = 0.0;
  for (std::size_t k = 1; k < light.size(); ++k) {
    light[k] /= last;
    if (!std::isfinite(light[k])) return false;
    fallen = std::max(fallen, light[k - 1] - light[k]);
    light[k] = std::max(light[k], light[k - 1] + 1e-9);
  }
  const double end = light.back();
  for (auto& value : light) value /= end;
  light.back() = 1.0;
  return fallen < 0.01;
}

// Tables at evenly spaced values 0..1, linear in between.
inline double light_at(const std::vector<double>& light, double value) {
  const double at = std::clamp(value, 0.0, 1.0) * static_cast<double>(light.size() - 1);
  const auto level = std::min(static_cast<std::size_t>(at), light.size() - 2);
  const double part = at - static_cast<double>(level);
  return light[level] + part * (light[level + 1] - light[level]);
}
inline double slope_at(const std::vector<double>& light, double value) {
  const double at = std::clamp(value, 0.0, 1.0) * static_cast<double>(light.size() - 1);
  const auto level = std::min(static_cast<std::size_t>(at), light.size() - 2);
  return (light[level + 1] - light[level]) * static_cast<double>(light.size() - 1);
}
inline double value_at(const std::vector<double>& light, double wanted) {
  if (wanted <= 0.0) return 0.0;
  if (wanted >= 1.0) return 1.0;
  const auto above = std::upper_bound(light.begin() + 1, light.end() - 1, wanted);
  const auto level = static_cast<std::size_t>(above - light.begin()) - 1;
  return (static_cast<double>(level) + (wanted - light[level]) / (light[level + 1] - light[level])) /
         static_cast<double>(light.size() - 1);
}

}  // namespace kasumi
