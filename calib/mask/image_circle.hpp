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
};

// The bright disc of a fisheye picture on a dark surround. Trees, buildings and a rim that is partly dark or cut by the
// image's border are allowed, as long as more than a quarter of the rim is visible. Empty when there is no such disc.
std::optional<ImageCircle> find_image_circle(const Image<Rgb8>& picture);

}  // namespace kasumi
