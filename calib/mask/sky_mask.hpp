// The permanently obstructed part of the sky camera's view, from many pictures of a day.
#pragma once

#include <span>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"

namespace kasumi {

struct SkyMask {
  Image<std::uint8_t> mask;   // 255 sky, 0 never
  Image<Rgb8> typical;        // what each pixel mostly shows, all pictures brought to one exposure
  int pictures = 0;           // that showed enough light
  double hidden_share = 0.0;  // of the upper hemisphere as far as the lens sees it, by solid angle
  double unsure_share = 0.0;  // of the same: told by its surroundings alone
};

// Each picture is brought to one exposure by its light around the zenith, and each pixel's median over the pictures is
// taken: clouds, birds, sun and flare pass, what stands stays. What is then far darker than the smooth sky fitted to
// its surroundings is not sky; what is neither clearly sky nor clearly dark is decided by likeness of colour and by
// edges (GrabCut). Nor is sky what the lens does not see, what lies below the horizon, or what hangs on neither the
// zenith nor a piece of its size. The mask then grows by `margin_px`, because an edge pixel is no sky.
// Pictures: 8 bits as encoded, of the camera's size. Errors (bad_input): none; none with enough light; a camera that
// does not see the sky above 50 deg of elevation.
Result<SkyMask> find_sky_mask(std::span<const Image<Rgb8>> pictures, const Camera& camera, double margin_px);

}  // namespace kasumi
