// The sun by its shape: the roundest, largest, loneliest bright area. That needs no smooth sky around, and finds the
// sun among clouds, streaks and drops, in a bloom, and by an unknown camera.
#pragma once

#include <optional>

#include "calib/camera.hpp"
#include "estimator/sky_camera/sun_in_image.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

// Empty where no bright area is likely enough: overcast, a cloud's white edge, too long an exposure.
std::optional<SunBlob> sun_by_shape(const SkyPicture& picture, const Camera& camera, const SunBlobLimits& options);

}  // namespace kasumi
