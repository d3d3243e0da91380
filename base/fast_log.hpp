// ln and exp for vectorised loops.
#pragma once

#include <bit>

namespace kasumi {

// Cephes' logf and expf without branches, so that loops over samples can be vectorised. Relative error 1e-7 for
// positive normal numbers, exponents within +-80.
inline float fast_log(float x) {
  const int bits = std::bit_cast<int>(x);
  const int exponent = (bits - 0x3f3504f3) >> 23;
  const float m = std::bit_cast<float>(bits - exponent * (1 << 23)) - 1.0f;
  float p = 7.0376836292e-2f;
  p = p * m - 1.1514610310e-1f;
  p = p * m + 1.1676998740e-1f;
  p = p * m - 1.2420140846e-1f;
  p = p * m + 1.4249322787e-1f;
  p = p * m - 1.6668057665e-1f;
  p = p * m + 2.0000714765e-1f;
  p = p * m - 2.4999993993e-1f;
  p = p * m + 3.3333331174e-1f;
  return m + m * m * (m * p - 0.5f) + static_cast<float>(exponent) * 0.693147181f;
}
inline float fast_exp(float x) {
  constexpr float kRound = 12582912.0f;  // adding it leaves the nearest integer in the low bits
  const float shifted = x * 1.44269504f + kRound;
  const float n = shifted - kRound;
  const float r = (x - n * 0.693359375f) + n * 2.12194440e-4f;
  float p = 1.9875691500e-4f;
  p = p * r + 1.3981999507e-3f;
  p = p * r + 8.3334519073e-3f;
  p = p * r + 4.1665795894e-2f;
  p = p * r + 1.6666665459e-1f;
  p = p * r + 5.0000001201e-1f;
  p = p * r * r + r + 1.0f;
  return p * std::bit_cast<float>((static_cast<int>(n) + 127) * (1 << 23));
}

}  // namespace kasumi
