// What sways before the scene camera: a soft mask from the pictures of some minutes.
#pragma once

#include <optional>
#include <span>

#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"

namespace kasumi {

struct SwayMask {
  // 255: never covered; 0: always; between: how much of the time and of the pixel was free. Empty: nothing sways.
  Image<std::uint8_t> mask;
  Image<Rgb8> typical;        // median of each pixel
  double moving_share = 0.0;  // of the picture or the box: covered at times, the band in which the matte is solved
  double hidden_share = 0.0;  // covered, mean over the time
};

// Leaves change the finest details of a picture again and again; light only scales them, clouds have no fine details,
// and passers-by pass once. So pixels whose detail (ln of light over its mean in 7 x 7 pixels) is often another are
// those where something sways, and with them what they enclose. What is behind is known at their rim and is followed
// inwards, from pixel to pixel, through the darker or the brighter half of each pixel's pictures; the other half is
// what sways. Where nothing of what is behind was ever seen, the pixel is always covered. A trunk that stands still is
// found only where leaves enclose it.
// Pictures: 8 bits as encoded, all of one size, in order of time; expected: kFewestSwayPictures or more. `box`: left,
// top, width, height, within the picture.
constexpr int kFewestSwayPictures = 12;
SwayMask find_sway_mask(std::span<const Image<Rgb8>> pictures, const Response& response,
                        const std::optional<glm::ivec4>& box);
// Hides what stands still, too, as another mask of that size says; where something sways, that is kept.
void add_still(SwayMask& sways, const Image<std::uint8_t>& still);

}  // namespace kasumi
