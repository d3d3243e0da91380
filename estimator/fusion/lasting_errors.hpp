// How an observer's error is divided between what its next reading repeats and what it does not.
#pragma once

#include <map>

#include "base/clock.hpp"
#include "estimator/fusion/gauss_markov.hpp"

namespace kasumi {

// Each lasting error is one quantity of the state, of spread 1, in units of its observer's recent sigma. If it were
// scaled by each reading's own sigma, two readings with different sigmas would make the error seem observable.
class LastingErrors {
 public:
  // `share`: of an observer's variance that lasts.
  explicit LastingErrors(double share) : share_(share) {}

  // Standard deviations: the weight of the lasting error in a reading that states `sigma`, and the rest.
  struct Parts {
    double lasting = 0.0, passing = 0.0;
  };
  // `state` loses what was known of the error as far as the stated sigmas have changed: it is then another error.
  Parts parts(GaussMarkov& state, std::size_t error, double sigma, Instant when);

 private:
  struct Usual {
    double sigma = 0.0;
    Instant when{};
  };
  double share_;
  std::map<std::size_t, Usual> usual_;  // by quantity
};

}  // namespace kasumi
