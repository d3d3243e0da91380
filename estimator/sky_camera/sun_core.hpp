// The compact bright spot that the sun itself makes in a picture.
#pragma once

#include <optional>

#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

struct SunCore {
  SunDirection direction{0.0, 0.0, 1.0};  // its centre of mass on the sphere
  Radians radius;                         // of a cap with the same solid angle
  double roundness = 1.0;                 // smaller over larger axis
  double level = 0.0;                     // encoded, of the dimmest channel where it is brightest
};

// The brightest spot within `reach` of a direction; where the picture is clipped, all that is clipped is the spot.
// Empty when there is none that ends within the reach. rim: of the brightest level, where the spot ends.
std::optional<SunCore> sun_core(const SkyPicture& picture, const Camera& camera, const SunDirection& near,
                                Radians reach, double saturated, double rim = 0.85);

}  // namespace kasumi
