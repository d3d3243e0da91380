// The sky camera's picture in the estimator's form: few pixels, floating point, still encoded.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"
#include "calib/camera.hpp"

namespace kasumi {

struct SkyPicture {
  Image<glm::vec3> encoded;  // R G B, 0..1, as the camera encodes it
  double step = 1.0;         // camera pixels from one element to the next
  glm::dvec2 first{};        // camera pixel of element (0, 0)
  double quantum = 0.0;      // smallest step of an encoded value: 1/255, 1/65535; 0: none

  glm::dvec2 camera_pixel(double x, double y) const { return first + step * glm::dvec2{x, y}; }
};

constexpr int kSkyPictureSide = 400;  // elements of about half a degree of a fisheye, the size of the sun

// Every n-th pixel, n such that the longer side has at most `largest_side` elements. Pixels are picked, not averaged:
// an average of encoded values is not proportional to light, and unused pixels need not be read. Error (bad_input): a
// size that is not the camera's.
Result<SkyPicture> sky_picture(const PictureView& view, const Camera& camera, int largest_side = kSkyPictureSide);
Result<SkyPicture> sky_picture(const Image<glm::vec3>& encoded, double quantum, const Camera& camera,
                               int largest_side = kSkyPictureSide);

}  // namespace kasumi
