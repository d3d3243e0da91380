// The sky as a function of direction, small enough for a shader's uniforms (docs/sky.md). What one altitude, turbidity
// and sun need; linear in its coefficients, so that skies may be blended and moved to other colour spaces by arithmetic
// on the coefficients.
#pragma once

#include <array>

#include <glm/vec3.hpp>

namespace kasumi {

// With v the unit vector of the view (world frame, z up), s that of the sun, h the sine of the horizon's elevation:
//   m = max(0, (v.z - h) / (1 - h))          0 at the geometric horizon and below it, 1 at the zenith
//   u = 1 / (1 + steepness * m)              1 at the horizon, small at the zenith
//   g = dot(v, s)
//   lobe(a) = ((1 - a)^2 / (1 + a^2 - 2 a g))^(3/2)       Henyey and Greenstein's, 1 towards the sun
//   A[0..5] = 1, g, g^2, lobe(lobes[0]), lobe(lobes[1]), lobe(lobes[2])
//   light = max(0, sum over j of A[j] * (c[j][0] + c[j][1] u + c[j][2] u^2 + ...))      Horner's scheme in u
// c[j][k] = coefficients[j * kDomePowers + k]. The sum has no exponential and no angle: 3 inverse square roots and a
// division for the whole colour. Why so: scattered once, light is a sum of (a function of the angle to the sun) times
// (a function of the zenith angle), exactly, in flat air; scattered often, it is smooth and the first terms hold it.
constexpr int kDomeAngles = 6;
constexpr int kDomePowers = 7;

struct DomeFunction {
  glm::vec3 sun{0, 0, 1};  // towards the sun, unit, world frame; may lie below the horizon
  float horizon_sine = 0;  // of the geometric horizon's elevation: 0 at sea level, -.097 at 30 km
  float steepness = 6;
  glm::vec3 lobes{0, 0, 0};                                         // asymmetries
  std::array<glm::vec3, kDomeAngles * kDomePowers> coefficients{};  // CIE XYZ, cd/m2, or another linear space
};

// The sun's disc: drawn over the dome by who needs it. Its edge lies kDomeSunRadius_rad (base/sky/sun_disc.hpp) from `sun`.
struct SunLight {
  glm::vec3 illuminance{0};  // on a plane facing the sun, at the observer; XYZ, lux; 0 when the sun has set there
  glm::vec3 luminance{0};    // of the disc, mean; XYZ, cd/m2
};

// Transparency of air between two points, by altitude above sea level and distance: base/sky/air_path.glsl explains.
//   transparency_c = sum over n of weight[n][c] exp(-(molecules[n][c] s_M + aerosol[n][c] s_A + ozone[n][c] s_O))
// with (s_M, s_A, s_O) the path's columns, which depend on no wavelength.
constexpr int kAirNodes = 2;
struct AirCoefficients {
  std::array<glm::vec3, kAirNodes> weight{};           // each channel's sum is 1
  std::array<glm::vec3, kAirNodes> molecules_per_m{};  // extinction at sea level
  std::array<glm::vec3, kAirNodes> aerosol_per_m{};
  std::array<glm::vec3, kAirNodes> ozone{};  // of the whole ozone layer, straight up
};

}  // namespace kasumi
