#include "gles/light/object_look.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {
namespace {

constexpr double kHalfAStep = 0.004;  // of 8 bits behind a response like sRGB; relative, of linear light
constexpr double kOtherNoise = 0.05;  // relative

bool differs(const glm::dvec3& a, const glm::dvec3& b, double relative) {
  for (int c = 0; c < 3; ++c)
    if (std::abs(a[c] - b[c]) > relative * std::max(std::abs(a[c]), std::abs(b[c]))) return true;
  return false;
}

}  // namespace

bool look_alike(const ObjectLook& a, const ObjectLook& b) {
  if (differs(glm::dvec3{a.measured.saturation}, glm::dvec3{b.measured.saturation}, kHalfAStep) ||
      a.measured.saturates() != b.measured.saturates() || a.measured.first_px != b.measured.first_px ||
      a.measured.last_px != b.measured.last_px || differs(a.noise.shot, b.noise.shot, kOtherNoise) ||
      differs(a.noise.read, b.noise.read, kOtherNoise))
    return false;
  return std::ranges::equal(a.measured.light, b.measured.light,
                            [](const glm::dvec3& p, const glm::dvec3& q) { return !differs(p, q, kHalfAStep); });
}

}  // namespace kasumi
