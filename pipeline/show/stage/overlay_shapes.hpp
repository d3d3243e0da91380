// The overlay's contents in pixels of the scene camera: a grid of azimuth and elevation, the horizon, the building's
// box, axes and heading, and the landmarks' expected positions. A wrong heading, place or scale shows as a mismatch
// between these lines and the picture.
#pragma once

#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "gles/model/model.hpp"
#include "pipeline/site/config/installation.hpp"

namespace kasumi {

enum class OverlayLineKind { grid, horizon, box, footprint, axis_x, axis_y, axis_z, heading, landmark };

struct OverlayLine {
  OverlayLineKind kind = OverlayLineKind::grid;
  std::vector<glm::dvec2> points;  // in order; points outside the picture may be missing
};

enum class OverlayLabelSide { left_of, right_of, above, below, on };

struct OverlayLabel {
  glm::dvec2 at{};
  OverlayLabelSide side = OverlayLabelSide::on;
  std::string text;
  bool may_be_left_out = false;  // if there is no room
};

struct OverlayShapes {
  std::vector<OverlayLine> lines;
  std::vector<OverlayLabel> labels;  // the important ones first
};

// Dip of the sea's horizon below the horizontal, with refraction.
Radians dip_of_horizon(double altitude_m);

// Directions are apparent ones, as everywhere in the scene camera: refraction is applied to places, not to the grid.
OverlayShapes overlay_shapes(const Installation& installation, const ModelBounds& bounds);

}  // namespace kasumi
