// The image circle of a fisheye.
#pragma once

#include <optional>

#include <glm/vec2.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

struct ImageCircle {
  glm::dvec2 centre{};
  double radius_px = 0.0;
  double sigma_px = 0.0;  // standard deviation of centre and radius as found
};

// The bright disc of a fisheye picture on a darker, even surround. Trees, buildings, a rim that is partly dark or cut
// by the frame on any side, flare and writing outside are allowed, as long as enough of the rim is visible to tell it
// from a skyline. Empty when there is no such disc.
std::optional<ImageCircle> find_image_circle(const Image<Rgb8>& picture);

}  // namespace kasumi
