// What the scene camera can see of the building's place: told when a kiosk starts, so that a slip of heading or place
// is not looked for in the picture.
#pragma once

#include <string>

#include <glm/vec3.hpp>

#include "gles/model/model.hpp"
#include "pipeline/config/installation.hpp"

namespace kasumi {

struct Sighting {
  enum class Verdict {
    visible,
    cut_off,         // the picture's edge cuts it
    outside,         // beside, above or below the picture
    behind,          // behind the camera
    below_horizon,   // the sea's curve hides it
    behind_the_mask  // everything of it lies behind what the foreground mask covers or the depth map has nearer
  };
  Verdict verdict = Verdict::visible;
  double distance_m = 0.0;
  std::string message;  // "the building is in the picture: 3.50 km away at azimuth 5.0 deg, 61 x 38 pixels"
  bool in_picture() const { return verdict == Verdict::visible || verdict == Verdict::cut_off; }
};

// Of the model's box in its place.
Sighting sight_object(const Installation& installation, const ModelBounds& bounds);

}  // namespace kasumi
