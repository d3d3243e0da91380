// Which camera file holds when: a camera was moved, refocused or replaced, and its archive goes on.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

class CalibrationPeriods {
 public:
  // Each "FROM..TO=FILE", FROM or TO left out at the ends: UTC days like 2019-05-01, or times; TO is no part of it.
  // Errors (bad_input): no such words, and gaps and overlaps between two of them.
  static Result<CalibrationPeriods> read(const std::vector<std::string>& given);
  bool empty() const { return periods_.empty(); }
  std::size_t size() const { return periods_.size(); }
  const std::string& file(std::size_t period) const { return periods_[period].file; }
  std::optional<std::size_t> at(Utc utc) const;  // empty: before all of them, or after

 private:
  struct Period {
    Utc from, to;
    std::string words, file;
  };
  std::vector<Period> periods_;  // in their order in time
};

}  // namespace kasumi
