#include "calib/light/one_view.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

namespace kasumi {
namespace {

constexpr int kCellsAcross = 96;  // means over cells hide noise, JPEG blocks and a shift by a pixel
constexpr std::size_t kFewestCells = 200;
constexpr double kDark = 4.0 / 255.0;
// Exposures of a still sky reach 0.986 and more, pictures of one camera some minutes apart 0.78 to 0.97.
constexpr double kLeastRankCorrelation = 0.98;
constexpr double kMostResidualSteps = 6.0;  // a view of little contrast correlates badly by noise alone
constexpr double kLeastLogRange = 0.05;
constexpr double kMostPredictionSteps = 3.0;

struct Cells {
  std::vector<double> a, b;
};

Cells cells_of(const Image<glm::vec3>& a, const Image<glm::vec3>& b, const Image<std::uint8_t>& mask) {
  Cells cells;
  const int side = std::max(1, std::min(a.width(), a.height()) / kCellsAcross);
  for (int top = 0; top + side <= a.height(); top += side)
    for (int left = 0; left + side <= a.width(); left += side) {
      double sum_a = 0.0, sum_b = 0.0;
      float highest = 0.0f;
      bool inside = true;
      for (int y = top; y < top + side; ++y)
        for (int x = left; x < left + side; ++x) {
          if (!mask.empty() && mask.at(x, y) == 0) inside = false;
          sum_a += static_cast<double>(a.at(x, y).y);
          sum_b += static_cast<double>(b.at(x, y).y);
          highest = std::max({highest, a.at(x, y).y, b.at(x, y).y});
        }
      const double mean_a = sum_a / (side * side), mean_b = sum_b / (side * side);
      if (!inside || highest >= static_cast<float>(kSaturated) || std::min(mean_a, mean_b) < kDark) continue;
      cells.a.push_back(mean_a);
      cells.b.push_back(mean_b);
    }
  return cells;
}

std::vector<std::size_t> rising_order(std::span<const double> values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, {}, [&](std::size_t i) { return values[i]; });
  return order;
}

// Equal values share the mean of their ranks.
std::vector<double> ranks_of(std::span<const double> values) {
  const auto order = rising_order(values);
  std::vector<double> ranks(values.size());
  for (std::size_t from = 0, to = 0; from < order.size(); from = to) {
    while (to < order.size() && values[order[to]] == values[order[from]]) ++to;
    for (std::size_t k = from; k < to; ++k) ranks[order[k]] = 0.5 * static_cast<double>(from + to - 1);
  }
  return ranks;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  const auto n = static_cast<double>(a.size());
  const double mean_a = std::accumulate(a.begin(), a.end(), 0.0) / n,
               mean_b = std::accumulate(b.begin(), b.end(), 0.0) / n;
  double ab = 0.0, aa = 0.0, bb = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    ab += (a[i] - mean_a) * (b[i] - mean_b);
    aa += (a[i] - mean_a) * (a[i] - mean_a);
    bb += (b[i] - mean_b) * (b[i] - mean_b);
  }
  return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : 0.0;
}

// rms of `values` around the best rising function of `of`, by pooling neighbours that fall (isotonic regression).
double residual_around_rising(const std::vector<double>& of, const std::vector<double>& values) {
  struct Pool {
    double sum, squares, count;
    double mean() const { return sum / count; }
  };
  std::vector<Pool> pools;
  const auto order = rising_order(of);
  for (std::size_t from = 0, to = 0; from < order.size(); from = to) {
    Pool pool{0.0, 0.0, 0.0};
    for (; to < order.size() && of[order[to]] == of[order[from]]; ++to) {
      const double value = values[order[to]];
      pool = {pool.sum + value, pool.squares + value * value, pool.count + 1.0};
    }
    while (!pools.empty() && pools.back().mean() >= pool.mean()) {
      const auto& last = pools.back();
      pool = {pool.sum + last.sum, pool.squares + last.squares, pool.count + last.count};
      pools.pop_back();
    }
    pools.push_back(pool);
  }
  double squares = 0.0;
  for (const auto& pool : pools) squares += pool.squares - pool.sum * pool.mean();
  return std::sqrt(std::max(0.0, squares) / static_cast<double>(values.size()));
}

// Every picture with every other.
class Comparisons {
 public:
  Comparisons(const ExposureStack& stack, const Image<std::uint8_t>& mask)
      : count_(stack.pictures.size()), found_(count_ * count_) {
    for (std::size_t i = 0; i < count_; ++i)
      for (std::size_t j = i + 1; j < count_; ++j)
        at(i, j) = at(j, i) = compare_views(stack.pictures[i], stack.pictures[j], mask);
  }
  std::optional<ViewAgreement>& at(std::size_t i, std::size_t j) { return found_[i * count_ + j]; }

  // The picture with which `i` agrees best; empty: `i` was compared with none.
  std::optional<std::size_t> most_like(std::size_t i) {
    std::optional<std::size_t> best;
    for (std::size_t j = 0; j < count_; ++j)
      if (at(i, j) && (!best || at(i, j)->rank_correlation > at(i, *best)->rank_correlation)) best = j;
    return best;
  }

  // The largest set of pictures in which each agrees with another.
  std::vector<bool> largest_view() {
    std::vector<bool> seen(count_, false), largest(count_, false);
    for (std::size_t start = 0; start < count_; ++start) {
      if (seen[start]) continue;
      std::vector<bool> group(count_, false);
      std::vector<std::size_t> open{start};
      while (!open.empty()) {
        const auto i = open.back();
        open.pop_back();
        if (seen[i]) continue;
        seen[i] = group[i] = true;
        for (std::size_t j = 0; j < count_; ++j)
          if (!seen[j] && at(i, j) && at(i, j)->one_view()) open.push_back(j);
      }
      if (std::ranges::count(group, true) > std::ranges::count(largest, true)) largest = std::move(group);
    }
    return largest;
  }

  bool contradicted(std::size_t i) {
    for (std::size_t j = 0; j < count_; ++j)
      if (at(i, j) && !at(i, j)->one_view()) return true;
    return false;
  }

 private:
  std::size_t count_;
  std::vector<std::optional<ViewAgreement>> found_;
};

}  // namespace

bool ViewAgreement::one_view() const {
  return rank_correlation >= kLeastRankCorrelation || residual_steps <= kMostResidualSteps;
}

std::optional<ViewAgreement> compare_views(const Image<glm::vec3>& a, const Image<glm::vec3>& b,
                                           const Image<std::uint8_t>& mask) {
  auto cells = cells_of(a, b, mask);
  if (cells.a.size() < kFewestCells) return std::nullopt;
  if (std::accumulate(cells.a.begin(), cells.a.end(), 0.0) > std::accumulate(cells.b.begin(), cells.b.end(), 0.0))
    std::swap(cells.a, cells.b);
  return ViewAgreement{correlation(ranks_of(cells.a), ranks_of(cells.b)),
                       255.0 * residual_around_rising(cells.a, cells.b)};
}

Result<> check_one_view(const ExposureStack& stack, const Image<std::uint8_t>& mask) {
  Comparisons comparisons(stack, mask);
  const auto view = comparisons.largest_view();
  const bool no_two = std::ranges::count(view, true) < 2;
  std::size_t others = 0;
  std::string named;
  for (std::size_t i = 0; i < stack.pictures.size(); ++i) {
    if ((view[i] && !no_two) || !comparisons.contradicted(i)) continue;
    ++others;
    const auto like = *comparisons.most_like(i);
    const auto& best = *comparisons.at(i, like);
    named += fmt::format("\n{}: at best {:.2f} and {:.1f} steps, with {}", stack.names[i], best.rank_correlation,
                         best.residual_steps, stack.names[like]);
  }
  if (others == 0) return {};
  return fail(FaultKind::bad_input,
              "{} of the {} pictures show another view than the rest: expected exposures of one view, camera and scene "
              "still, whose levels rise together (rank correlation of {} or more, or at most {:.0f} steps of 255 left "
              "after the best tone curve){}",
              others, stack.pictures.size(), kLeastRankCorrelation, kMostResidualSteps, named);
}

Result<> check_exposure_ratios(const KnownStack& known) {
  const auto& log_s = known.stack.log_s;
  const auto [least, most] = std::ranges::minmax(log_s);
  if (most - least >= kLeastLogRange) return {};
  std::string named;
  for (std::size_t k = 0; k < log_s.size(); ++k)
    named += fmt::format("{}{} {:.3f}", k == 0 ? "" : ", ", known.stack.names[k], std::exp(log_s[k] - least));
  return fail(
      FaultKind::bad_input,
      "all exposures are the same within {:.0f} %, so that the pictures say nothing of the response: relative to "
      "the shortest {} they are {}: expected each 2 to 4 times the one before",
      100.0 * kLeastLogRange, known.exposures.known ? "as given" : "as estimated from the pictures", named);
}

Result<> check_prediction(const ResponseCalibration& calibration, const StackSamples& samples,
                          const KnownStack& known) {
  const double to_steps = 255.0 * samples.quantum, found = to_steps * calibration.held_out_steps;
  if (found <= kMostPredictionSteps) return {};
  const auto errors = prediction_errors(samples, calibration.fit);
  const auto worst = static_cast<std::size_t>(std::ranges::max_element(errors) - errors.begin());
  return fail(FaultKind::bad_input,
              "the best curve ({}) predicts the pictures to {:.1f} steps of 255 (rms), expected at most {:.0f}; worst "
              "in {}, {:.1f} steps: expected exposures of one view, camera and scene still, each 2 to 4 times the one "
              "before{}",
              calibration.fit.method, found, kMostPredictionSteps, known.stack.names[worst], to_steps * errors[worst],
              known.exposures.known ? ", with their true times" : "");
}

}  // namespace kasumi
