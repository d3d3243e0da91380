#include "estimator/sky/haze_scattering.hpp"

#include <glm/common.hpp>

namespace kasumi {
namespace {

// Fitted to ln p of the kinds' Mie sums at 550 nm, every degree from 3 to 170; albedo at 610, 550 and 465 nm
// (docs/sky.md; tests/estimator/sky/test_haze_scattering.cpp compares).
struct KindLobes {
  glm::dvec3 albedo;
  double forwards, backwards;  // asymmetries
  double share_forwards;
};
KindLobes lobes_of(AerosolKind kind) {
  switch (kind) {
    case AerosolKind::continental: return {{0.907, 0.911, 0.917}, 0.70, -0.68, 0.99};
    case AerosolKind::polluted: return {{0.868, 0.873, 0.879}, 0.70, -0.68, 0.99};
    case AerosolKind::urban: return {{0.782, 0.788, 0.795}, 0.70, -0.56, 0.98};
    case AerosolKind::maritime: return {{0.997, 0.997, 0.997}, 0.82, -0.66, 0.97};
    case AerosolKind::desert: return {{0.904, 0.883, 0.842}, 0.77, -0.76, 0.97};
    case AerosolKind::dust: return {{0.870, 0.835, 0.763}, 0.83, -0.80, 0.97};
    case AerosolKind::smoke: return {{0.888, 0.893, 0.898}, 0.58, -0.20, 1.00};
  }
  return lobes_of(AerosolKind::continental);
}

}  // namespace

sky_text::HazeScattering haze_scattering(AerosolKind kind) {
  const KindLobes lobes = lobes_of(kind);
  const auto height = [](double share, double g) { return share * (1.0 + g) / ((1.0 - g) * (1.0 - g)); };
  return {lobes.albedo,
          {lobes.forwards, lobes.backwards},
          {height(lobes.share_forwards, lobes.forwards), height(1.0 - lobes.share_forwards, lobes.backwards)}};
}

sky_text::HazeScattering haze_scattering(const Aerosol& aerosol) {
  const sky_text::HazeScattering one = haze_scattering(aerosol.kind);
  if (aerosol.other_share <= 0.0) return one;
  const sky_text::HazeScattering other = haze_scattering(aerosol.other);
  const double share = aerosol.other_share;
  return {glm::mix(one.albedo, other.albedo, share), glm::mix(one.asymmetry, other.asymmetry, share),
          glm::mix(one.height, other.height, share)};
}

}  // namespace kasumi
