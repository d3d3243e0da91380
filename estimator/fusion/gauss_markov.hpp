// Some quantities that drift at random and are pulled back to where they usually are, known with a covariance.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "base/clock.hpp"

namespace kasumi {

struct Normal {
  double mean = 0.0, variance = 0.0;
};

// Mean and variance of what is left of `before` after an observation of this ln likelihood (any function), by sums over
// a grid. Also holds for one-sided likelihoods (bounds), and for normal ones far out in `before`.
Normal after_observing(const Normal& before, const std::function<double(double)>& log_likelihood);

// A Gauss-Markov (Ornstein-Uhlenbeck) process.
struct DriftingQuantity {
  double usual = 0.0;                  // mean, when nothing is known
  double spread = 0.0;                 // standard deviation, when nothing is known; 0: it is fixed
  Duration memory{};                   // after this time e^-1 of what was known is left
  double drift_per_root_hour() const;  // standard deviation that an hour adds to a known value, for hours << memory
};

class GaussMarkov {
 public:
  using Row = std::vector<double>;  // weights of a sum of the quantities, as many as these

  // At first each is where it usually is.
  explicit GaussMarkov(std::vector<DriftingQuantity> quantities);

  std::size_t size() const { return quantities_.size(); }
  const DriftingQuantity& quantity(std::size_t i) const { return quantities_[i]; }
  double mean(std::size_t i) const { return mean_[i]; }
  double variance(std::size_t i) const { return covariance_[i * size() + i]; }
  double covariance(std::size_t i, std::size_t j) const { return covariance_[i * size() + j]; }
  Normal sum(const Row& row) const;

  void advance(Duration time);
  // The sum of `row` was seen to be `value`; `variance`: of errors that no other observation has.
  void observe(const Row& row, double value, double variance);
  // Conditions the state on the sum of `row`, whose distribution changes from `before` to `after`. `before` allows for
  // a sum that is not quite linear.
  void condition(const Row& row, const Normal& before, const Normal& after);
  // The quantity has jumped by about so much.
  void doubt(std::size_t i, double variance);
  // So much (0..1) of what was known of its distance from where it usually is remains.
  void forget(std::size_t i, double kept);
  // As known from elsewhere; what was known of it is forgotten.
  void set(std::size_t i, const Normal& known);

 private:
  std::vector<DriftingQuantity> quantities_;
  std::vector<double> mean_, covariance_;  // n, and n x n by rows
};

}  // namespace kasumi
