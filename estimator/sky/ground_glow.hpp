// The dome's sky stands over ground of albedo .2. Over brighter ground the air sends more light back down, above all
// near the horizon, where as much air is lit from below as from above (physics 12).
#pragma once

#include <glm/vec3.hpp>

#include "base/aerosol.hpp"

namespace kasumi {

constexpr double kDomeGroundAlbedo = 0.2;  // of the reference atmosphere that the dome's table was made with

class GroundGlow {
 public:
  // Wavelengths whose depths stand for linear sRGB's R, G, B by default.
  static constexpr glm::dvec3 kChannels_nm{610.0, 550.0, 465.0};
  // `lit`: what falls on level ground under the dome as it is, in linear sRGB. `channels_nm`: whose depths the channels
  // have.
  GroundGlow(const Aerosol& aerosol, double altitude_m, double ground_albedo, const glm::dvec3& lit,
             const glm::dvec3& channels_nm = kChannels_nm);

  // What the sky has more (or less) than the dome's in a direction, by the cosine of its zenith angle; linear sRGB.
  glm::dvec3 radiance(double cos_zenith) const { return more_from_ground_ * sent_back(cos_zenith); }
  // The sky's albedo, seen from below.
  const glm::dvec3& sky_albedo() const { return sky_albedo_; }

 private:
  glm::dvec3 sent_back(double cos_zenith) const;  // per radiance of the ground

  glm::dvec3 molecules_{0.0}, aerosol_{0.0};  // optical depths above the site
  glm::dvec3 aerosol_albedo_{1.0};
  glm::dvec3 sky_albedo_{0.0};
  glm::dvec3 more_from_ground_{0.0};  // radiance
};

}  // namespace kasumi
