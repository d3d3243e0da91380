#include "base/colour_difference.hpp"

#include <cmath>

#include "base/units.hpp"

namespace kasumi {
namespace {

double degrees(double radians) {
  const double d = radians * 180.0 / kPi;
  return d < 0.0 ? d + 360.0 : d;
}
double cos_deg(double d) {
  return std::cos(d * kPi / 180.0);
}

}  // namespace

glm::dvec3 lab_of(const glm::dvec3& xyz, double white_luminance) {
  const auto f = [](double t) { return t > 216.0 / 24389.0 ? std::cbrt(t) : (24389.0 / 27.0 * t + 16.0) / 116.0; };
  const double x = f(xyz.x / (0.95047 * white_luminance)), y = f(xyz.y / white_luminance),
               z = f(xyz.z / (1.08883 * white_luminance));
  return {116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)};
}

double ciede2000(const glm::dvec3& one, const glm::dvec3& two) {
  const double c_mean = 0.5 * (std::hypot(one.y, one.z) + std::hypot(two.y, two.z));
  const auto seventh = [](double c) { return std::sqrt(std::pow(c, 7) / (std::pow(c, 7) + std::pow(25.0, 7))); };
  const double g = 0.5 * (1.0 - seventh(c_mean));
  const double a1 = (1.0 + g) * one.y, a2 = (1.0 + g) * two.y;
  const double c1 = std::hypot(a1, one.z), c2 = std::hypot(a2, two.z);
  const double h1 = c1 == 0.0 ? 0.0 : degrees(std::atan2(one.z, a1)),
               h2 = c2 == 0.0 ? 0.0 : degrees(std::atan2(two.z, a2));
  const bool grey = c1 * c2 == 0.0;
  double turn = grey ? 0.0 : h2 - h1;
  if (turn > 180.0) turn -= 360.0;
  if (turn < -180.0) turn += 360.0;
  const double dl = two.x - one.x, dc = c2 - c1, dh = 2.0 * std::sqrt(c1 * c2) * std::sin(0.5 * turn * kPi / 180.0);
  double h = h1 + h2;
  if (!grey) {
    if (std::abs(h1 - h2) > 180.0) h += h < 360.0 ? 360.0 : -360.0;
    h *= 0.5;
  }
  const double l = 0.5 * (one.x + two.x), c = 0.5 * (c1 + c2);
  const double t = 1.0 - 0.17 * cos_deg(h - 30.0) + 0.24 * cos_deg(2.0 * h) + 0.32 * cos_deg(3.0 * h + 6.0) -
                   0.20 * cos_deg(4.0 * h - 63.0);
  const double l50 = (l - 50.0) * (l - 50.0);
  const double sl = 1.0 + 0.015 * l50 / std::sqrt(20.0 + l50), sc = 1.0 + 0.045 * c, sh = 1.0 + 0.015 * c * t;
  const double around = 30.0 * std::exp(-std::pow((h - 275.0) / 25.0, 2));
  const double rt = -2.0 * seventh(c) * std::sin(2.0 * around * kPi / 180.0);
  const double x = dl / sl, y = dc / sc, z = dh / sh;
  return std::sqrt(x * x + y * y + z * z + rt * y * z);
}

}  // namespace kasumi
