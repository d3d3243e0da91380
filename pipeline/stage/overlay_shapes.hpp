// What the overlay shows, in pixels of the scene camera: a grid of azimuth and elevation, the horizon, the building's
// box, axes and heading, and landmarks where they should be. A slip of heading, place or scale shows as a difference
// between these lines and the picture under them.
#pragma once

#include <string>
#include <vector>

#include <glm/vec2.hpp>

#include "gles/model/model.hpp"
#include "pipeline/config/installation.hpp"

namespace kasumi {

enum class OverlayLineKind { grid, horizon, box, footprint, axis_x, axis_y, axis_z, heading, landmark };

struct OverlayLine {
  OverlayLineKind kind = OverlayLineKind::grid;
  std::vector<glm::dvec2> points;  // one after the other; what lies outside the picture may be missing
};

enum class OverlayLabelSide { left_of, right_of, above, below, on };

struct OverlayLabel {
  glm::dvec2 at{};
  OverlayLabelSide side = OverlayLabelSide::on;
  std::string text;
  bool may_be_left_out = false;  // where there is no room
};

struct OverlayShapes {
  std::vector<OverlayLine> lines;
  std::vector<OverlayLabel> labels;  // the important ones first
};

// How far below the level the sea's horizon is seen from that altitude, refraction included.
Radians dip_of_horizon(double altitude_m);

// Directions are as the eye has them, as everywhere in the scene camera: refraction is in the places, not in the grid.
OverlayShapes overlay_shapes(const Installation& installation, const ModelBounds& bounds);

}  // namespace kasumi
