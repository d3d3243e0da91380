// The sky as its camera sees it, clouds and all: what lights the object where the clear sky's model does not hold
// (physics 6).
#pragma once

#include <array>
#include <cstddef>

#include <glm/vec3.hpp>

#include "base/geometry.hpp"
#include "base/image.hpp"
#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/turbidity/sky_samples.hpp"

namespace kasumi {

struct SkyCell {
  glm::dvec3 xyz{0.0};   // mean radiance, in the sky camera's own unit
  double seen = 0.0;     // share of the cell that is open to the camera, 0 where it does not look
  double clear = 0.0;    // share of that which is clear air
  bool clipped = false;  // some of it is brighter than the camera can tell
};

struct MeasuredSky {
  static constexpr int kRings = 18, kSectors = 36;  // 5 deg of zenith angle by 10 deg of azimuth
  std::array<SkyCell, static_cast<std::size_t>(kRings) * kSectors> cells{};
  double sun_share = 1.0;  // of the direct sunlight that reaches the object, 0 under a cloud

  const SkyCell& at(const Direction& direction) const;  // at and below the horizon the lowest ring
  static Direction centre_of(int ring, int sector);
};

// Where a cloud that shades the object is seen from the sky camera: where the ray from the object (metres east, north,
// up of the camera) to the sun meets the clouds' base, metres above the camera. The sun itself when it is too low.
Direction towards_shading_cloud(const glm::dvec3& object_m, const SunDirection& sun, double cloud_base_m);

// `use`: of every element of the picture, clouds marked (SkyLook::use). Clouds are told from clear air by it, the sun's
// disc by its saturated pixels. `through`: where a cloud would shade the object.
MeasuredSky measure_sky(const SkyPicture& picture, const SkyGeometry& geometry, const Camera& camera,
                        const Image<PixelUse>& use, SkyCondition condition, const SunDirection& sun,
                        const Direction& through);

// How differently two skies would light an object, for deciding whether to draw it anew: the largest change of the
// cloud cover of a quarter of the sky, or of the share of the sun.
double difference(const MeasuredSky& a, const MeasuredSky& b);

}  // namespace kasumi
