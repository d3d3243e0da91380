// The sun by the sky around it: precise to a fraction of a degree, but only in smooth sky.
#pragma once

#include <optional>

#include "calib/camera.hpp"
#include "estimator/sky_camera/sun_in_image.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

// Where two ways of looking at it agree: the centre of the sky around, which grows dimmer with the distance from the
// sun, and the middle of its brightest spot. Empty where they do not, or where nothing looks like the sun's
// surroundings: overcast, a cloud's white edge, a reflection, too long an exposure.
std::optional<SunBlob> sun_by_aureole(const SkyPicture& picture, const Camera& camera, const SunBlobLimits& options);

}  // namespace kasumi
