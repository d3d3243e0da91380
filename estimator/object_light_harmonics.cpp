#include <cmath>
#include <cstddef>

#include "estimator/object_light.hpp"

namespace kasumi {
namespace {

// Convolution with the clamped cosine, by degree: pi, 2 pi / 3, pi / 4.
constexpr std::array<double, 9> kCosineLobe = {kPi,     2 * kPi / 3, 2 * kPi / 3, 2 * kPi / 3, kPi / 4,
                                               kPi / 4, kPi / 4,     kPi / 4,     kPi / 4};

}  // namespace

std::array<double, 9> harmonic_basis(const Direction& n) {
  constexpr double k0 = 0.28209479177387814;   // 1 / (2 sqrt(pi))
  constexpr double k1 = 0.48860251190291992;   // sqrt(3 / (4 pi))
  constexpr double k2 = 1.09254843059207907;   // sqrt(15 / (4 pi))
  constexpr double k20 = 0.31539156525252001;  // sqrt(5 / (16 pi))
  return {k0,
          k1 * n.y,
          k1 * n.z,
          k1 * n.x,
          k2 * n.x * n.y,
          k2 * n.y * n.z,
          k20 * (3.0 * n.z * n.z - 1.0),
          k2 * n.x * n.z,
          0.5 * k2 * (n.x * n.x - n.y * n.y)};
}

glm::dvec3 irradiance(const IrradianceHarmonics& harmonics, const Direction& normal) {
  const auto basis = harmonic_basis(normal);
  glm::dvec3 sum{0.0};
  for (std::size_t i = 0; i < basis.size(); ++i) sum += harmonics[i] * basis[i];
  return sum;
}

IrradianceHarmonics sky_harmonics(const std::function<glm::dvec3(const Direction&)>& radiance) {
  // Midpoints in azimuth (periodic, converges fast) and in zenith angle, which crowds samples at the horizon where the
  // clear sky changes fastest.
  constexpr int kZeniths = 48;
  constexpr int kAzimuths = 72;
  constexpr double kZenithStep = kPi / 2.0 / kZeniths;
  constexpr double kAzimuthStep = 2.0 * kPi / kAzimuths;
  IrradianceHarmonics harmonics{};
  for (int i = 0; i < kZeniths; ++i) {
    const double zenith = (i + 0.5) * kZenithStep;
    // Exact solid angle of the band, so that an even sky is exact.
    const double solid_angle =
        kAzimuthStep * (std::cos(zenith - 0.5 * kZenithStep) - std::cos(zenith + 0.5 * kZenithStep));
    for (int j = 0; j < kAzimuths; ++j) {
      const Direction direction = direction_from({zenith}, {(j + 0.5) * kAzimuthStep});
      const glm::dvec3 power = radiance(direction) * solid_angle;
      const auto basis = harmonic_basis(direction);
      for (std::size_t k = 0; k < basis.size(); ++k) harmonics[k] += kCosineLobe[k] * basis[k] * power;
    }
  }
  return harmonics;
}

IrradianceHarmonics ground_harmonics(const glm::dvec3& radiance) {
  // pi L (1 - n_z) / 2, which has no part of degree 2.
  const auto up = harmonic_basis({0.0, 0.0, 1.0});
  IrradianceHarmonics harmonics{};
  harmonics[0] = 0.5 * kPi / up[0] * radiance;
  harmonics[2] = -0.5 * kPi / up[2] * radiance;
  return harmonics;
}

}  // namespace kasumi
