// Where one surface ends and another begins. A difference of range between neighbours is a step where it is much larger
// than the differences two to five pixels to either side. The ground's perspective, however steep before the horizon,
// is not a step; an edge smeared over three pixels by a scanner's beam or by scaling is.
#include <algorithm>
#include <cmath>

#include "estimator/haze/range.hpp"

namespace kasumi {
namespace {

constexpr float kSmallestStep = 0.05F;  // of the range
constexpr float kSteeper = 2.5F;        // than its surroundings, by this factor
constexpr int kFrom = 2, kTo = 5;       // pixels to either side

float wrapped(float sum) {
  return sum - kRangeStepTurn * std::floor(sum / kRangeStepTurn);
}

// `ln_range`: of a row or column; `sums` receives the sum of the steps before each pixel.
void sum_steps(const std::vector<float>& ln_range, std::vector<float>& sums) {
  const int count = static_cast<int>(ln_range.size());
  const auto difference = [&](int i) {  // between pixel i and the next; none beyond the ends
    const int at = std::clamp(i, 0, count - 2);
    return ln_range[static_cast<std::size_t>(at) + 1] - ln_range[static_cast<std::size_t>(at)];
  };
  const auto least_beside = [&](int i, int side) {
    float least = std::abs(difference(i + side * kFrom));
    for (int away = kFrom + 1; away <= kTo; ++away) least = std::min(least, std::abs(difference(i + side * away)));
    return least;
  };
  double sum = 0.0;
  for (int i = 0; i < count && count > 1; ++i) {
    sums[static_cast<std::size_t>(i)] = wrapped(static_cast<float>(sum));
    if (i + 1 == count) break;
    const float step = difference(i);
    // The smeared parts of a larger step count too, unless the surface varies that much anyway.
    if (std::abs(step) < kSmallestStep / 3.0F) continue;
    if (std::abs(step) > kSteeper * std::max(least_beside(i, -1), least_beside(i, 1))) sum += static_cast<double>(step);
  }
}

}  // namespace

Image<float> range_steps_along_row(const Image<float>& range) {
  Image<float> steps(range.width(), range.height());
  std::vector<float> ln_range(static_cast<std::size_t>(range.width())), sums(ln_range.size());
  for (int y = 0; y < range.height(); ++y) {
    std::transform(range.row(y), range.row(y) + range.width(), ln_range.begin(), [](float r) { return std::log(r); });
    sum_steps(ln_range, sums);
    std::ranges::copy(sums, steps.row(y));
  }
  return steps;
}

Image<float> range_steps_down_column(const Image<float>& range) {
  Image<float> steps(range.width(), range.height());
  std::vector<float> ln_range(static_cast<std::size_t>(range.height())), sums(ln_range.size());
  for (int x = 0; x < range.width(); ++x) {
    for (int y = 0; y < range.height(); ++y) ln_range[static_cast<std::size_t>(y)] = std::log(range.at(x, y));
    sum_steps(ln_range, sums);
    for (int y = 0; y < range.height(); ++y) steps.at(x, y) = sums[static_cast<std::size_t>(y)];
  }
  return steps;
}

}  // namespace kasumi
