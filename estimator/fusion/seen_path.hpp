// What a reading of a path says of the state's quantities, channel by channel.
#pragma once

#include <vector>

#include "estimator/fusion/air_observation.hpp"
#include "estimator/fusion/gauss_markov.hpp"
#include "estimator/fusion/lasting_errors.hpp"

namespace kasumi {

// One channel, as optical depth of a column whose air near the ground is as the path's.
struct SeenChannel {
  PathReading::Channel::Kind kind{};
  std::size_t error{};  // the quantity that is its own lasting error
  double wavelength_nm = 550.0;
  double aod = 0.0, sigma = 0.0, shared_sigma = 0.0;  // at this wavelength; aod may come out below 0
  double lasting = 0.0, lasting_shared = 0.0;         // of its log amount
  double passing_share = 1.0;                         // of sigma

  // The sum of quantities that its log amount is, around the present state, and what that is expected to be.
  struct Sum {
    GaussMarkov::Row row;
    Normal expected;
  };
  Sum sum(const GaussMarkov& state) const;
  // How far what was read is from a log amount; 0 where a bound holds.
  double beyond(double log_amount_there) const;
  // ln, with `sigma` for its error; a bound is one-sided.
  double log_likelihood(double log_amount_there, double sigma) const;
};

// Those that say anything, the nearest to 550 nm first.
std::vector<SeenChannel> seen_path(const PathReading& reading, double altitude_m, GaussMarkov& state,
                                   LastingErrors& errors, Instant when);

}  // namespace kasumi
