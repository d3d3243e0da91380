#include "calib/light/jpeg_block.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "base/units.hpp"

namespace kasumi {
namespace {

JpegBlock multiplied(const JpegBlock& values, bool back, bool rows) {
  static const auto kCosines = [] {
    std::array<double, 64> cosines{};
    for (std::size_t u = 0; u < 8; ++u)
      for (std::size_t i = 0; i < 8; ++i)
        cosines[8 * u + i] = (u == 0 ? std::sqrt(0.125) : 0.5) *
                             std::cos((2.0 * static_cast<double>(i) + 1.0) * static_cast<double>(u) * kPi / 16.0);
    return cosines;
  }();
  JpegBlock out{};
  for (std::size_t y = 0; y < 8; ++y)
    for (std::size_t x = 0; x < 8; ++x)
      for (std::size_t k = 0; k < 8; ++k) {
        const std::size_t to = rows ? x : y;
        const double weight = back ? kCosines[8 * k + to] : kCosines[8 * to + k];
        out[8 * y + x] += weight * (rows ? values[8 * y + k] : values[8 * k + x]);
      }
  return out;
}

}  // namespace

JpegBlock coefficients_of(const JpegBlock& samples) {
  return multiplied(multiplied(samples, false, true), false, false);
}

JpegBlock samples_of(const JpegBlock& coefficients) {
  return multiplied(multiplied(coefficients, true, true), true, false);
}

double step_of(const BlockSteps& steps, std::size_t i) {
  return std::max<double>(steps[i], 1.0);
}

}  // namespace kasumi
