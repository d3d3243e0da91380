// Order statistics of many values, as a picture has them: counted, where sorting would take most of the time.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace kasumi {

// The value with `n` of them before it in ascending order, n < values.size(); exactly what std::nth_element finds. No
// value may be NaN.
inline float nth_smallest(std::span<const float> values, std::size_t n) {
  constexpr std::size_t kFew = 256, kBins = 512;  // fewer are sorted sooner than counted; a cache holds the counts
  std::vector<float> some;
  const auto of_some = [&some](std::size_t nth) {
    const auto at = some.begin() + static_cast<std::ptrdiff_t>(nth);
    std::nth_element(some.begin(), at, some.end());
    return *at;
  };
  const auto [lowest, highest] = std::ranges::minmax(values);
  const float scale = static_cast<float>(kBins - 1) / (highest - lowest);
  if (values.size() < kFew || !std::isnormal(scale)) {
    some.assign(values.begin(), values.end());
    return of_some(n);
  }
  // Rounding keeps the order: what is larger is in no lower bin.
  const auto bin_of = [low = lowest, scale](float value) {
    return std::min(static_cast<std::size_t>((value - low) * scale), kBins - 1);
  };
  std::array<std::size_t, kBins> counts{};
  for (const float value : values) ++counts[bin_of(value)];
  std::size_t bin = 0, before = 0;
  while (before + counts[bin] <= n) before += counts[bin++];
  some.reserve(counts[bin]);
  for (const float value : values)
    if (bin_of(value) == bin) some.push_back(value);
  return of_some(n - before);
}

// As median_in_place() and quantile_in_place() of base/statistics.hpp, which reorder the values.
inline float counted_median(std::span<const float> values) {
  return values.empty() ? 0.0f : nth_smallest(values, values.size() / 2);
}
inline float counted_quantile(std::span<const float> values, double share) {
  return values.empty()
             ? 0.0f
             : nth_smallest(values, static_cast<std::size_t>(share * static_cast<double>(values.size() - 1)));
}

}  // namespace kasumi
