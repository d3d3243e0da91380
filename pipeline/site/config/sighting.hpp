// Whether the building lies in the scene camera's view: reported when a kiosk starts, so that a wrong heading or place
// is noticed at once.
#pragma once

#include <string>

#include <string_view>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "gles/model/model.hpp"
#include "pipeline/site/config/installation.hpp"

namespace kasumi {

struct Sighting {
  enum class Verdict {
    visible,
    cut_off,         // the picture's edge cuts it
    outside,         // left, right, above or below the picture
    behind,          // behind the camera
    below_horizon,   // hidden by the earth's curvature
    behind_the_mask  // completely behind the foreground mask or nearer parts of the depth map
  };
  Verdict verdict = Verdict::visible;
  double distance_m = 0.0;
  // What its box covers, where it is in the picture: centres of the outermost pixels, which may lie outside.
  glm::dvec2 least_px{}, greatest_px{};
  std::string message;  // "the building is in the picture: 3.50 km away at azimuth 5.0 deg, 61 x 38 pixels"
  bool in_picture() const { return verdict == Verdict::visible || verdict == Verdict::cut_off; }
};

// For the model's bounding box at its place, or that of a part of it. `what`: its name in the message.
Sighting sight_object(const Installation& installation, const ModelBounds& bounds,
                      std::string_view what = "the building");

}  // namespace kasumi
