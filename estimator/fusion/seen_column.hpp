// What a reading of the column says of the state's quantities.
#pragma once

#include <cstddef>
#include <optional>

#include "estimator/fusion/air_observation.hpp"
#include "estimator/fusion/gauss_markov.hpp"
#include "estimator/fusion/lasting_errors.hpp"

namespace kasumi {

// The sum of `row` was seen as `value`, with an error of its own besides the lasting ones in the row.
struct SeenSum {
  GaussMarkov::Row row;
  double value = 0.0;
  double passing_sigma = 0.0;
};

struct SeenColumn {
  Normal amount;                                 // log amount, all errors together
  double exponent = 0.0, exponent_sigma = 0.0;   // Angstrom's; the part that the amount's error does not bring
  std::size_t amount_error{}, exponent_error{};  // the quantities that are its lasting errors
  SeenSum amounts;
  SeenSum exponents;  // less what the amount's error does to the exponent's
};

// Empty: impossible numbers.
std::optional<SeenColumn> seen_column(const ColumnReading& reading, GaussMarkov& state, LastingErrors& errors,
                                      Instant when);

}  // namespace kasumi
