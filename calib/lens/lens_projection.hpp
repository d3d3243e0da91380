// Differentiable versions of the lens models, for fits with Ceres. Everything else uses calib/lens/lens.hpp;
// tests/calib checks that the two agree.
#pragma once

#include <array>
#include <cmath>

#include <ceres/jet.h>

#include "calib/lens/lens_fit.hpp"

namespace kasumi {

inline double value_of(double x) {
  return x;
}
template <class T, int N>
double value_of(const ceres::Jet<T, N>& x) {
  return x.a;
}

// [fx, fy, cx, cy, k1, k2, k3, k4]
struct FisheyeProjection {
  static constexpr int kParameters = 8;
  template <class T>
  static bool project(const T* p, const T* ray, T* pixel) {
    using std::atan2, std::sqrt;
    const T off2 = ray[0] * ray[0] + ray[1] * ray[1];
    if (value_of(off2) < 1e-18) {
      pixel[0] = p[2] + p[0] * ray[0] / ray[2];
      pixel[1] = p[3] + p[1] * ray[1] / ray[2];
      return value_of(ray[2]) > 0.0;
    }
    const T off = sqrt(off2), theta = atan2(off, ray[2]), t2 = theta * theta;
    const T radius = theta * (T(1.0) + t2 * (p[4] + t2 * (p[5] + t2 * (p[6] + t2 * p[7]))));
    pixel[0] = p[2] + p[0] * radius * ray[0] / off;
    pixel[1] = p[3] + p[1] * radius * ray[1] / off;
    return true;
  }
};

// [f, b2, b3, b4, cx, cy, c, d]: forward(s) = f (1 + b2 s^2 + b3 s^3 + b4 s^4), s = rho / f. So scaled, all numbers are
// of a size.
struct ScaramuzzaProjection {
  static constexpr int kParameters = 8;
  // tan(theta) = s / forward(s); zero where s is right. `off`, `z`: the ray across and along the axis.
  template <class T>
  static T miss(const T* p, double s, const T& off, const T& z) {
    return off * (T(1.0) + s * s * (p[1] + s * (p[2] + s * p[3]))) - s * z;
  }
  static double slope(const double* b, double s, double off, double z) {
    return off * s * (2.0 * b[0] + s * (3.0 * b[1] + s * 4.0 * b[2])) - z;
  }
  template <class T>
  static bool project(const T* p, const T* ray, T* pixel) {
    using std::sqrt;
    const T off2 = ray[0] * ray[0] + ray[1] * ray[1];
    if (value_of(off2) < 1e-18) return false;
    const T off = sqrt(off2);
    const std::array b{value_of(p[1]), value_of(p[2]), value_of(p[3])};
    const double length = std::hypot(value_of(off), value_of(ray[2]));
    const double sine = value_of(off) / length, cosine = value_of(ray[2]) / length;
    double s = std::atan2(sine, cosine);  // an equidistant lens's, to begin with
    for (int i = 0; i < 50; ++i) {
      const double m = sine * (1.0 + s * s * (b[0] + s * (b[1] + s * b[2]))) - s * cosine;
      const double step = m / slope(b.data(), s, sine, cosine);
      if (!std::isfinite(step) || std::abs(s) > 100.0) return false;
      s -= step;
      if (std::abs(step) < 1e-14) break;
    }
    if (!(s > 0.0)) return false;
    // One more step carries the derivatives: the implicit function's.
    const double at = slope(b.data(), s, value_of(off), value_of(ray[2]));
    const T radius = p[0] * (T(s) - miss(p, s, off, ray[2]) / T(at));
    const T u = radius * ray[0] / off, v = radius * ray[1] / off;
    pixel[0] = p[4] + u;
    pixel[1] = p[5] + p[6] * v + p[7] * u;
    return true;
  }
};

// [fx, fy, cx, cy, k1, k2, p1, p2, k3]
struct PinholeProjection {
  static constexpr int kParameters = 9;
  template <class T>
  static bool project(const T* p, const T* ray, T* pixel) {
    if (!(value_of(ray[2]) > 1e-6)) return false;
    const T x = ray[0] / ray[2], y = ray[1] / ray[2], r2 = x * x + y * y;
    const T radial = T(1.0) + r2 * (p[4] + r2 * (p[5] + r2 * p[8]));
    pixel[0] = p[2] + p[0] * (x * radial + 2.0 * p[6] * x * y + p[7] * (r2 + 2.0 * x * x));
    pixel[1] = p[3] + p[1] * (y * radial + p[6] * (r2 + 2.0 * y * y) + 2.0 * p[7] * x * y);
    return true;
  }
};

}  // namespace kasumi
