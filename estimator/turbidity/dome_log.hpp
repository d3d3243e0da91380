// ln of the dome's luminance as a function of T, for one altitude, sun and kind of aerosol: the model to fit where the
// site's sky is the dome.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "base/aerosol.hpp"
#include "base/sky/dome_function.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

class DomeLog {
 public:
  // `like`: an aerosol of which only the amount is to be found; empty: the dome's usual one, T 1.7 to 10.
  DomeLog(double altitude_m, const SunDirection& sun, const std::optional<Aerosol>& like = std::nullopt);
  // The T at both ends: with an aerosol given, from none of it to the haziest dome or T 20.
  Turbidity lowest() const { return lowest_; }
  Turbidity highest() const { return highest_; }

  // ln Y at one place of the sky, for T at nodes uniform in ln(T - shift), a node more at either end where there is one.
  static constexpr std::size_t kNodes = 17;
  using Nodes = std::array<float, kNodes>;
  Nodes at(double cos_zenith, double cos_sun_distance) const;

  // Cubics between the nodes (Catmull-Rom; quadratics at the last), the same for all places: ln Y and its slope in T
  // are sums over four nodes. The error is below .001 of ln Y.
  struct Between {
    std::size_t first = 0;
    std::array<double, 4> value{}, slope{};
    double value_of(const Nodes& nodes) const { return sum(value, nodes); }
    double slope_of(const Nodes& nodes) const { return sum(slope, nodes); }

   private:
    double sum(const std::array<double, 4>& weights, const Nodes& nodes) const;
  };
  Between between(Turbidity turbidity) const;  // clamped to the ends

 private:
  Turbidity node(std::size_t k) const;

  Turbidity lowest_, highest_;
  double shift_ = 0.0;
  double first_, step_;  // in ln(T - shift)
  std::array<DomeFunction, kNodes> domes_;
};

inline double DomeLog::Between::sum(const std::array<double, 4>& weights, const Nodes& nodes) const {
  double sum = 0.0;
  for (std::size_t k = 0; k < 4; ++k) sum += weights[k] * static_cast<double>(nodes[first + k]);
  return sum;
}

}  // namespace kasumi
