#include "estimator/sky/ground_glow.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>

#include "base/units.hpp"
#include "estimator/air/scattering.hpp"
#include "estimator/sky/haze_scattering.hpp"

namespace kasumi {
namespace {

// The share of light from half a sphere, even, that aerosol scatters back into a direction: half of it along the
// horizon, little overhead (as the air before land has it, docs/sky.md).
double aerosol_back_share(double cosine) {
  return 0.5 * (1.0 - cosine / std::sqrt(0.15 + 1.79 * cosine * cosine));
}

}  // namespace

GroundGlow::GroundGlow(const Aerosol& aerosol, double altitude_m, double ground_albedo, const glm::dvec3& lit,
                       const glm::dvec3& channels_nm)
    : aerosol_albedo_(haze_scattering(aerosol).albedo) {
  for (int c = 0; c < 3; ++c) {
    const double nm = channels_nm[c];
    molecules_[c] = molecular_optical_depth(nm) * std::exp(-altitude_m / kRayleighScaleHeight_m);
    aerosol_[c] = optical_depth(aerosol, nm) * std::exp(-altitude_m / kAerosolHeight_m);
  }
  // Of even light from below, the irradiance that comes back at once; of what comes back as much is scattered again.
  constexpr int kSteps = 32;
  glm::dvec3 once{0.0};
  for (int i = 0; i < kSteps; ++i) once += sent_back(std::sqrt((i + 0.5) / kSteps)) / static_cast<double>(kSteps);
  sky_albedo_ = once / (1.0 - once);
  // Ground and sky send it to each other.
  const glm::dvec3 here = lit * (1.0 - kDomeGroundAlbedo * sky_albedo_) / (1.0 - ground_albedo * sky_albedo_);
  more_from_ground_ = (ground_albedo * here - kDomeGroundAlbedo * lit) / kPi;
}

glm::dvec3 GroundGlow::sent_back(double cos_zenith) const {
  const double cosine = std::max(cos_zenith, 0.0);
  const glm::dvec3 depth = molecules_ + aerosol_;
  const glm::dvec3 back = 0.5 * molecules_ + aerosol_back_share(cosine) * aerosol_albedo_ * aerosol_;
  return back / glm::max(depth, glm::dvec3{1e-9}) * (1.0 - glm::exp(-depth / std::max(cosine, 0.01))) *
         (1.0 + sky_albedo_);
}

}  // namespace kasumi
