// Strangers' sky pictures with circle, sun and clouds labelled by hand: ../shared/data/sky/real/README.md.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "calib/mask/image_circle.hpp"

namespace kasumi::test {

struct LabelledSky {
  std::string id, file, name;  // name: of the camera that took it
  Image<Rgb8> pixels;
  Camera camera;                     // equidistant, the labelled circle at 90 deg
  std::vector<ImageCircle> circles;  // any of them is right: the horizon's and the image's edge
  double circle_tolerance = 0.02;    // of the radius
  bool sun_scored = false;           // a disc or a blob, or none to be seen
  std::optional<glm::dvec2> sun_px;  // where it is
  double tolerance_px = 0.0;         // 2 deg, or what the label is uncertain by
  std::string sky;                   // class: "clear", "unknown"
  std::optional<double> cloud;       // fraction, by a mask
};

// Those with a circle. Empty where the data are not.
std::vector<LabelledSky> labelled_skies();

}  // namespace kasumi::test
