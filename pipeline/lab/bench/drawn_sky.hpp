// Skies whose cost is measured.
#pragma once

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "estimator/sky/preetham.hpp"

namespace kasumi {

// A sky of Preetham's with its sun's surroundings, as an upright fisheye of `side` pixels with 8 bits sees it.
Image<Rgb8> drawn_sky(int side, Camera& camera, const SunDirection& sun);

}  // namespace kasumi
