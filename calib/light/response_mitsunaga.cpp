#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "calib/light/response_fit.hpp"
#include "calib/light/response_levels.hpp"

namespace kasumi {
namespace {

constexpr int kRounds = 25;
constexpr std::size_t kPixels = 2000;  // a handful of coefficients need no more

// f(v) = v + sum over n = 2 .. N of c_n (v^n - v): through black, and 1 at 1.
class Curve {
 public:
  explicit Curve(int order) : c_(Eigen::VectorXd::Zero(std::max(0, order - 1))) {}
  Eigen::VectorXd& coefficients() { return c_; }
  Eigen::Index size() const { return c_.size(); }

  double at(double v) const {
    double light = v, power = v;
    for (Eigen::Index n = 0; n < c_.size(); ++n) {
      power *= v;
      light += c_(n) * (power - v);
    }
    return light;
  }
  double slope(double v) const {
    double slope = 1.0, power = 1.0;
    for (Eigen::Index n = 0; n < c_.size(); ++n) {
      power *= v;
      slope += c_(n) * (static_cast<double>(n + 2) * power - 1.0);
    }
    return slope;
  }

 private:
  Eigen::VectorXd c_;
};

class Fit {
 public:
  Fit(const StackSamples& samples, const KnownExposures& exposures, int order)
      : samples_(samples),
        exposures_(exposures),
        order_(by_brightness(samples)),
        curves_(3, Curve(order)),
        log_s_(exposures.log_s),
        stride_(std::max<std::size_t>(1, samples.pixels / kPixels)) {}

  // Gauss-Newton on all channels and exposures together. False: it diverges.
  bool solve() {
    for (int round = 0; round < kRounds; ++round) {
      const double step = improve();
      if (!std::isfinite(step)) return false;
      if (step < 1e-9) return true;
    }
    return true;  // not fully converged is good enough: the curve is judged by its predictions
  }

  std::optional<ResponseFit> result(int order) const {
    ResponseFit fit;
    fit.method = fmt::format("Mitsunaga-Nayar, order {}", order);
    fit.log_s = log_s_;
    fit.is_straight = order == 1;
    for (std::size_t c = 0; c < 3; ++c) {
      std::vector<double> light;
      for (std::size_t k = 0; k < kCurveLevels; ++k)
        light.push_back(curves_[c].at(static_cast<double>(k) / static_cast<double>(kCurveLevels - 1)));
      if (!make_curve(light)) return std::nullopt;
      fit.light[c] = std::move(light);
    }
    return fit;
  }

 private:
  double improve() {
    const Eigen::Index per_channel = curves_[0].size(), exposures = static_cast<Eigen::Index>(samples_.exposures);
    const Eigen::Index size = 3 * per_channel + exposures;
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(size, size);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
    Eigen::VectorXd row(per_channel + 2);
    for (Eigen::Index c = 0; c < 3; ++c) {
      auto& curve = curves_[static_cast<std::size_t>(c)];
      // Rows touch one channel's coefficients and two exposures.
      std::vector<Eigen::Index> columns(static_cast<std::size_t>(per_channel) + 2);
      for (Eigen::Index n = 0; n < per_channel; ++n) columns[static_cast<std::size_t>(n)] = c * per_channel + n;
      for (std::size_t k = 0; k + 1 < order_.size(); ++k) {
        const std::size_t dark = order_[k], bright = order_[k + 1];
        const double ratio = std::exp(log_s_[bright] - log_s_[dark]);
        columns[static_cast<std::size_t>(per_channel)] = 3 * per_channel + static_cast<Eigen::Index>(bright);
        columns[static_cast<std::size_t>(per_channel) + 1] = 3 * per_channel + static_cast<Eigen::Index>(dark);
        for (std::size_t i = 0; i < samples_.pixels; i += stride_) {
          const double a = samples_.at(static_cast<int>(c), i, bright), b = samples_.at(static_cast<int>(c), i, dark);
          // Selected by the brighter of the two alone, so that noise of the darker one does not bias the selection.
          if (a >= kSaturated || a < 4.0 * samples_.quantum || b >= kSaturated) continue;
          const double light_b = curve.at(b);
          const double sigma = samples_.quantum * std::hypot(curve.slope(a), ratio * curve.slope(b)) + 1e-12;
          double power_a = a, power_b = b;
          for (Eigen::Index n = 0; n < per_channel; ++n) {
            power_a *= a;
            power_b *= b;
            row(n) = ((power_a - a) - ratio * (power_b - b)) / sigma;
          }
          row(per_channel) = -ratio * light_b / sigma;
          row(per_channel + 1) = ratio * light_b / sigma;
          const double residual = (curve.at(a) - ratio * light_b) / sigma;
          for (Eigen::Index p = 0; p < per_channel + 2; ++p) {
            const auto column = columns[static_cast<std::size_t>(p)];
            right(column) -= row(p) * residual;
            for (Eigen::Index q = 0; q < per_channel + 2; ++q)
              normal(column, columns[static_cast<std::size_t>(q)]) += row(p) * row(q);
          }
        }
      }
    }
    hold_exposures(normal, right, 3 * per_channel);
    for (Eigen::Index p = 0; p < size; ++p) normal(p, p) += 1e-12 * (1.0 + normal(p, p));
    const Eigen::VectorXd step = normal.ldlt().solve(right);
    for (Eigen::Index c = 0; c < 3; ++c)
      curves_[static_cast<std::size_t>(c)].coefficients() += step.segment(c * per_channel, per_channel);
    for (Eigen::Index j = 0; j < exposures; ++j) log_s_[static_cast<std::size_t>(j)] += step(3 * per_channel + j);
    return step.lpNorm<Eigen::Infinity>();
  }

  // Holds the exposures to what is known of them, or else only their mean, since a common factor belongs to the light.
  void hold_exposures(Eigen::MatrixXd& normal, Eigen::VectorXd& right, Eigen::Index first) const {
    const auto count = static_cast<Eigen::Index>(samples_.exposures);
    if (!exposures_.known) {
      normal.bottomRightCorner(count, count).array() += 1e3;
      return;
    }
    const double weight = exposures_.sigma > 0.0 ? 1.0 / (exposures_.sigma * exposures_.sigma) : 1e16;
    for (Eigen::Index j = 0; j < count; ++j) {
      normal(first + j, first + j) += weight;
      right(first + j) +=
          weight * (exposures_.log_s[static_cast<std::size_t>(j)] - log_s_[static_cast<std::size_t>(j)]);
    }
  }

  const StackSamples& samples_;
  const KnownExposures& exposures_;
  std::vector<std::size_t> order_;
  std::vector<Curve> curves_;
  std::vector<double> log_s_;
  std::size_t stride_;
};

}  // namespace

std::optional<ResponseFit> fit_mitsunaga(const StackSamples& samples, const KnownExposures& exposures, int order) {
  Fit fit(samples, exposures, order);
  if (!fit.solve()) return std::nullopt;
  return fit.result(order);
}

}  // namespace kasumi
