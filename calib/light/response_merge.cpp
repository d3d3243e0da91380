#include <algorithm>
#include <cmath>

#include "calib/light/response_fit.hpp"
#include "calib/light/response_levels.hpp"

namespace kasumi {

Image<glm::vec3> merge_stack(const std::vector<Image<glm::vec3>>& pictures, double quantum, const glm::dvec3& black,
                             const ResponseFit& fit, const NoiseModel& noise) {
  const double longest = *std::max_element(fit.log_s.begin(), fit.log_s.end());
  const double shortest = *std::min_element(fit.log_s.begin(), fit.log_s.end());
  std::vector<double> s;
  for (const double log_s : fit.log_s) s.push_back(std::exp(log_s - longest));
  Image<glm::vec3> merged(pictures.front().width(), pictures.front().height());
  for (std::size_t i = 0; i < merged.elements().size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const auto& curve = fit.light[static_cast<std::size_t>(c)];
      double sum = 0.0, weights = 0.0;
      bool bright = false;
      for (std::size_t j = 0; j < pictures.size(); ++j) {
        const double value = (static_cast<double>(pictures[j].elements()[i][c]) - black[c]) / (1.0 - black[c]);
        if (value >= kSaturated) {
          bright = true;
          continue;
        }
        const double light = light_at(curve, value), slope = slope_at(curve, value);
        const double variance = noise.variance(light) + std::pow(quantum * slope, 2) / 12.0 + 1e-12;
        // A value of 0 counts like any other; leaving it out would bias the mean upwards.
        const double weight = s[j] * s[j] / variance;
        sum += weight * light / s[j];
        weights += weight;
      }
      double light = weights > 0.0 ? sum / weights : 0.0;
      if (!(weights > 0.0) && bright) light = std::exp(longest - shortest);
      merged.elements()[i][c] = static_cast<float>(light);
    }
  return merged;
}

std::vector<double> over_black(const std::vector<double>& light, double black) {
  if (!(black > 0.0)) return light;
  std::vector<double> table;
  constexpr double kNothing = 1e-7;  // tables must rise strictly
  const auto last = static_cast<double>(light.size() - 1);
  for (std::size_t k = 0; k < light.size(); ++k) {
    const double part = static_cast<double>(k) / last, value = (part - black) / (1.0 - black);
    table.push_back(kNothing * part + (1.0 - kNothing) * (value > 0.0 ? light_at(light, value) : 0.0));
  }
  table.back() = 1.0;
  return table;
}

}  // namespace kasumi
