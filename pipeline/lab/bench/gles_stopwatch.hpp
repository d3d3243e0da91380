// Times draw calls alternately, waiting for each to finish; keeps the first fault.
#pragma once

#include <algorithm>
#include <limits>

#include <GLES2/gl2.h>

#include "base/result.hpp"
#include "pipeline/lab/bench/bench.hpp"

namespace kasumi {

class Stopwatch {
 public:
  template <class A, class B>
  double ratio(A a, B b, int pairs = 31) {
    return paired_ratio([&] { finish(a()); }, [&] { finish(b()); }, pairs);
  }
  // A software rasterizer's by the processor, a GPU's by the clock.
  template <class A>
  double least_seconds(A a, int times, bool software) {
    double least = std::numeric_limits<double>::infinity();
    const auto work = [&] { finish(a()); };
    for (int i = 0; i < times; ++i) least = std::min(least, software ? processor_seconds_of(work) : seconds_of(work));
    return least;
  }
  const Result<>& result() const { return result_; }

 private:
  void finish(const Result<>& drawn) {
    glFinish();
    if (result_ && !drawn) result_ = drawn;
  }
  Result<> result_;
};

}  // namespace kasumi
