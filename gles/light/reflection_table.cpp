#include "gles/light/reflection_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "base/units.hpp"

namespace kasumi {
namespace {

constexpr double kMinRoughness = 1e-3;  // a mirror: its samples coincide, and the integrals stay valid

}  // namespace

double facet_cosine(double share, double alpha) {
  return std::sqrt((1.0 - share) / (1.0 + (alpha * alpha - 1.0) * share));
}

// Samples facets evenly from the GGX distribution; each reflects 4 V n.l v.h / n.h of the incident light.
DirectionalAlbedo directional_albedo(double across, double roughness) {
  constexpr int kTilts = 64, kTurns = 16;
  const double alpha = std::pow(std::max(roughness, kMinRoughness), 2), a2 = alpha * alpha;
  const double sideways = std::sqrt(1.0 - across * across);
  const auto shadow = [&](double outer, double inner) { return outer * std::sqrt(inner * inner * (1.0 - a2) + a2); };
  DirectionalAlbedo sum{0.0, 0.0, 0.0, 0.0};
  for (int i = 0; i < kTilts; ++i) {
    const double nh = facet_cosine((i + 0.5) / kTilts, alpha), tilt = std::sqrt(1.0 - nh * nh);
    for (int j = 0; j < kTurns; ++j) {
      const double vh = sideways * tilt * std::cos(kPi * (j + 0.5) / kTurns) + across * nh;
      const double nl = 2.0 * vh * nh - across;
      if (vh <= 0.0 || nl <= 0.0) continue;
      const double weight = 2.0 * nl * vh / nh / (shadow(nl, across) + shadow(across, nl)) / (kTilts * kTurns);
      sum.all += weight;
      sum.edge += weight * std::pow(1.0 - vh, 5);
      sum.along += weight * nl;
      sum.aside += weight * (sideways - 2.0 * vh * tilt * std::cos(kPi * (j + 0.5) / kTurns));
    }
  }
  sum.along /= sum.all;
  sum.aside /= sum.all;
  return sum;
}

double mean_cosine(double roughness) {
  constexpr int kTilts = 1024;
  const double alpha = std::pow(std::max(roughness, kMinRoughness), 2);
  double weights = 0.0, sum = 0.0;
  for (int i = 0; i < kTilts; ++i) {
    const double nh = facet_cosine((i + 0.5) / kTilts, alpha), nl = 2.0 * nh * nh - 1.0;
    if (nl <= 0.0) continue;
    weights += nl;
    sum += nl * nl;
  }
  return sum / weights;
}

ReflectionLookup reflection_lookup(double across, const DirectionalAlbedo& back) {
  ReflectionLookup lookup;
  const double sideways = std::sqrt(1.0 - across * across), slope = std::max(back.aside, 0.0) / back.along;
  if (sideways > 0.0) lookup.lean = std::clamp(slope / (sideways + slope * (1.0 - across)), 0.0, 1.0);
  static const auto cosines = [] {
    std::array<double, 129> list{};
    for (std::size_t i = 0; i < list.size(); ++i) list[i] = mean_cosine(double(i) / (list.size() - 1));
    return list;
  }();
  const double length = std::hypot(back.along, back.aside);
  std::size_t rougher = 1;
  while (rougher + 1 < cosines.size() && cosines[rougher] > length) ++rougher;
  const double part = (cosines[rougher - 1] - length) / (cosines[rougher - 1] - cosines[rougher]);
  lookup.roughness = std::clamp((double(rougher) - 1.0 + part) / (cosines.size() - 1), 0.0, 1.0);
  return lookup;
}

Image<glm::u8vec4> reflection_table() {
  const auto byte = [](double value) {
    return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 1.0) * 255.0));
  };
  Image<glm::u8vec4> table(kReflectionTableSize, kReflectionTableSize);
  for (int y = 0; y < table.height(); ++y)
    for (int x = 0; x < table.width(); ++x) {
      const double root = std::max(static_cast<double>(x) / (table.width() - 1), 0.01);
      const DirectionalAlbedo back = directional_albedo(root * root, static_cast<double>(y) / (table.height() - 1));
      const ReflectionLookup lookup = reflection_lookup(root * root, back);
      table.at(x, y) = {byte(back.all), byte(back.edge), byte(lookup.lean), byte(lookup.roughness)};
    }
  return table;
}

}  // namespace kasumi
