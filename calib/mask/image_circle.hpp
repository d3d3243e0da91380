// The image circle of a fisheye.
#pragma once

#include <optional>
#include <vector>

#include <glm/vec2.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"

namespace kasumi {

struct ImageCircle {
  glm::dvec2 centre{};
  double radius_px = 0.0;
  double sigma_px = 0.0;  // standard deviation of centre and radius as found
};

struct PossibleCircle {
  ImageCircle circle;
  double confidence = 0.0;
};

struct FoundCircle {
  // In a picture whose pixels were made square by stretching its columns: x is pixel_aspect times the column, lengths
  // are in rows. With square pixels these are the picture's own coordinates.
  ImageCircle circle;
  double confidence = 0.0;             // 0..1: that centre and radius are within 2 % of the radius
  std::optional<ImageCircle> horizon;  // a second rim inside `circle`: where sky ends and a ring of land begins
  double pixel_aspect = 1.0;           // width of a pixel over its height; 1 unless the rim is clearly an ellipse
  std::vector<PossibleCircle> others;  // what else it may be, for a comparison with other pictures of the same camera
};

// A picture with less confidence is no fisheye picture: photographs of other things stay below 0.003.
constexpr double kLeastCircleConfidence = 0.03;

// The most likely circle, however faint its rim: on a surround of any even colour, with trees, walls, flare, text or
// rings, cut by the frame on any side. Empty only where nothing in the picture is round.
std::optional<FoundCircle> find_image_circle(const Image<Rgb8>& picture);

}  // namespace kasumi
