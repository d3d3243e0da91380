// Figures of `kasumi bench`: ratios of two alternately measured tasks in one process, so that the machine's speed and
// load cancel out.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace kasumi {

struct BenchRow {
  std::string name;  // "cached composite / plain blit, full HD"
  double value = 0.0;
  std::string unit = "x";
  std::optional<double> goal;  // none: for information only
  bool less_is_better = true;  // and a goal is an upper bound; else a lower one
  bool reached() const { return !goal || (less_is_better ? value <= *goal : value >= *goal); }
};

// Seconds of one call.
double seconds_of(const std::function<void()>& work);
// The same of processor time, of all threads of this process: other programs' load does not count.
double processor_seconds_of(const std::function<void()>& work);
// Of the quickest of several: what the machine does beside only adds to it.
double least_seconds_of(const std::function<void()>& work, int times);
// Runs a and b in turn, `pairs` times after one unmeasured pair, and gives the median of time(a) / time(b).
double paired_ratio(const std::function<void()>& a, const std::function<void()>& b, int pairs);

std::vector<BenchRow> bench_turbidity();
// From a sky camera's picture to its air.
std::vector<BenchRow> bench_sky_answer();
std::vector<BenchRow> bench_air();
// Pictures of an archive against the decoding of their JPEGs. Error: io (no room for temporary files).
Result<std::vector<BenchRow>> bench_archive();

}  // namespace kasumi
