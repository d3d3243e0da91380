// For variances.
#pragma once

namespace kasumi {

constexpr double square(double x) {
  return x * x;
}

}  // namespace kasumi
