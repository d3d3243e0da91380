// Times draw calls alternately, waiting for each to finish; keeps the first fault.
#pragma once

#include <GLES2/gl2.h>

#include "base/result.hpp"
#include "pipeline/bench/bench.hpp"

namespace kasumi {

class Stopwatch {
 public:
  template <class A, class B>
  double ratio(A a, B b, int pairs = 31) {
    return paired_ratio([&] { finish(a()); }, [&] { finish(b()); }, pairs);
  }
  template <class A>
  double least_seconds(A a, int times) {
    return least_seconds_of([&] { finish(a()); }, times);
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
