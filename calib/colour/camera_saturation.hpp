// How far a camera moves colours away from grey, as most that make sRGB do to please the eye: behind its white balance
// and before its tone curve, L' = Y + s (L - Y) in each channel, Y being the luminance of L.
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace kasumi {

constexpr glm::dvec3 kLuminanceOfSrgb{0.2126, 0.7152, 0.0722};  // IEC 61966-2-1
constexpr double kLeastSaturation = 0.5, kMostSaturation = 3.0;

// Linear light, white balanced, in any unit, as a camera of that saturation shows it; 1 / saturation leads back. Of
// deep colours a channel may come out below 0.
inline glm::dvec3 with_saturation(const glm::dvec3& light, double saturation) {
  const double grey = glm::dot(light, kLuminanceOfSrgb);
  return grey + saturation * (light - grey);
}

}  // namespace kasumi
