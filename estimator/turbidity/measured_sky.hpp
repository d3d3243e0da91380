// The sky as its camera sees it, including clouds: the object's light where the clear sky's model does not apply
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

struct MeasuredCell {
  glm::dvec3 xyz{0.0};   // mean radiance, in the sky camera's own unit
  double seen = 0.0;     // share of the cell that is open to the camera; 0 where it does not look
  double clear = 0.0;    // share of that which is clear air
  bool clipped = false;  // some of it exceeds the camera's range
};

struct MeasuredSky {
  static constexpr int kRings = 18, kSectors = 36;  // 5 deg of zenith angle by 10 deg of azimuth
  std::array<MeasuredCell, static_cast<std::size_t>(kRings) * kSectors> cells{};
  double sun_share = 1.0;  // of the direct sunlight that reaches the object, 0 under a cloud

  const MeasuredCell& at(const Direction& direction) const;  // at and below the horizon the lowest ring
  static Direction centre_of(int ring, int sector);
};

// The direction, from the sky camera, of a cloud that shades the object: where the ray from the object (metres east,
// north, up of the camera) to the sun meets the cloud base, in metres above the camera. The sun's direction when it is
// too low.
Direction towards_shading_cloud(const glm::dvec3& object_m, const SunDirection& sun, double cloud_base_m);

// `use`: for every element of the picture, clouds marked (SmoothAureole::use). It separates clouds from clear air. The sun's
// disc is recognised by its saturated pixels; where there is none, `uncovered_sun` (SmoothAureole) stands for it. `through`:
// where a cloud would shade the object.
MeasuredSky measure_sky(const SkyPicture& picture, const ElementGeometry& geometry, const Camera& camera,
                        const Image<PixelUse>& use, SkyCondition condition, const SunDirection& sun,
                        const Direction& through, double uncovered_sun = 0.0);

// How differently two skies would light an object, to decide whether to redraw it: the largest change in the cloud
// cover of a quarter of the sky, or in the share of the sun.
double difference(const MeasuredSky& a, const MeasuredSky& b);

}  // namespace kasumi
