// The permanently obstructed part of the sky camera's view, from many pictures of a day.
#pragma once

#include <span>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"

namespace kasumi {

struct SkyMask {
  Image<std::uint8_t> mask;   // 255: sky, 0: never sky
  Image<Rgb8> typical;        // median of each pixel, all pictures brought to one exposure
  int pictures = 0;           // those with enough light
  double hidden_share = 0.0;  // of the upper hemisphere as far as the lens sees it, by solid angle
  double unsure_share = 0.0;  // of the same: decided from its surroundings alone
};

// Each picture is brought to one exposure by its light around the zenith. The median of each pixel over the pictures
// removes clouds, birds, sun and flare, and keeps obstructions. Pixels far darker than a smooth sky fitted to their
// surroundings are not sky; those neither clearly sky nor clearly dark are decided by colour and edges (GrabCut). Nor
// are pixels sky outside the lens's view, below the horizon, or in small pieces not connected to the zenith. The
// obstructions then grow by `margin_px`, because edge pixels are mixed.
// Pictures: 8 bits as encoded, of the camera's size. Errors (bad_input): none; none with enough light; a camera that
// does not see the sky above 50 deg of elevation.
Result<SkyMask> find_sky_mask(std::span<const Image<Rgb8>> pictures, const Camera& camera, double margin_px);

}  // namespace kasumi
