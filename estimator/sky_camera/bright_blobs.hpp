// The compact bright areas of a sky picture, any of which may be the sun, with the features that identify it.
#pragma once

#include <optional>
#include <vector>

#include "base/units.hpp"
#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

// Levels are of the dimmest channel, encoded, over that of the brightest elements, unless stated otherwise.
struct BrightBlob {
  SunDirection direction{0.0, 0.0, 1.0};  // of its middle
  Radians radius;                         // of the largest circle that fits into it
  Radians scatter;                        // of its middle between two levels
  std::optional<Radians> lowered;         // how far a sky that is brighter below moves its middle; empty: unknown
  Radians resolution;                     // of one element there
  double share = 0.0;                     // of all that is as bright in the sky, how much that circle covers
  double around = 0.0;                    // median level 5 deg outside of it
  double spread = 0.0;                    // of these levels, between their quartiles
};

struct BrightBlobs {
  std::vector<BrightBlob> blobs;
  double middle = 0.0;  // median level of the sky
};

// saturated: encoded level from which a channel is clipped. No blobs where the whole sky is dark.
BrightBlobs bright_sky(const SkyPicture& picture, const Camera& camera, double saturated);

}  // namespace kasumi
