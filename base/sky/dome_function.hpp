// The sky as a function of direction for one altitude, turbidity and sun, small enough for a shader's uniforms
// (docs/sky.md). It is linear in its coefficients, so skies can be blended and converted to other colour spaces by
// arithmetic on the coefficients.
#pragma once

#include <array>

#include <glm/vec3.hpp>

namespace kasumi {

// With v the unit view vector (world frame, z up), s the unit vector towards the sun, h the sine of the horizon's
// elevation:
//   m = max(0, (v.z - h) / (1 - h))          0 at the geometric horizon and below it, 1 at the zenith
//   u = 1 / (1 + steepness * m)              1 at the horizon, small at the zenith
//   g = dot(v, s)
//   lobe(a) = ((1 - a)^2 / (1 + a^2 - 2 a g))^(3/2)       Henyey-Greenstein, 1 towards the sun
//   A[0..5] = 1, g, g^2, lobe(lobes[0]), lobe(lobes[1]), lobe(lobes[2])
//   light = max(0, sum over j of A[j] * (c[j][0] + c[j][1] u + c[j][2] u^2 + ...))      Horner's scheme in u
// c[j][k] = coefficients[j * kDomePowers + k]. The sum has no exponential and no angle: 3 inverse square roots and a
// division for the whole colour. Singly scattered light in flat air is exactly a sum of products of (a function of the
// angle to the sun) and (a function of the zenith angle); multiply scattered light is smooth, so a few terms suffice.
constexpr int kDomeAngles = 6;
constexpr int kDomePowers = 7;

struct DomeFunction {
  glm::vec3 sun{0, 0, 1};  // towards the sun, unit, world frame; may lie below the horizon
  float horizon_sine = 0;  // of the geometric horizon's elevation: 0 at sea level, -.097 at 30 km
  float steepness = 6;
  glm::vec3 lobes{0, 0, 0};                                         // asymmetries
  std::array<glm::vec3, kDomeAngles * kDomePowers> coefficients{};  // CIE XYZ, cd/m2, or another linear space
};

// The sun's disc, drawn over the dome where needed. Its edge lies kDomeSunRadius_rad (base/sky/sun_disc.hpp) from
// `sun`.
struct SunLight {
  glm::vec3 illuminance{0};  // on a plane facing the sun, at the observer; XYZ, lux; 0 when the sun has set there
  glm::vec3 luminance{0};    // of the disc, mean; XYZ, cd/m2
};

// Transparency of the air between two points, from their altitudes above sea level and their distance
// (base/sky/air_path.glsl).
//   transparency_c = sum over n of weight[n][c] exp(-(molecules[n][c] s_M + aerosol[n][c] s_A + ozone[n][c] s_O))
// with (s_M, s_A, s_O) the path's columns, which do not depend on wavelength.
constexpr int kAirNodes = 2;
struct AirCoefficients {
  std::array<glm::vec3, kAirNodes> weight{};           // each channel's sum is 1
  std::array<glm::vec3, kAirNodes> molecules_per_m{};  // extinction at sea level
  std::array<glm::vec3, kAirNodes> aerosol_per_m{};
  std::array<glm::vec3, kAirNodes> ozone{};  // of the whole ozone layer, vertically
};

}  // namespace kasumi
