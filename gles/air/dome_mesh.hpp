// Where the sky's picture is computed, so that it may be drawn straight in between.
#pragma once

#include <vector>

#include "base/sky/dome_scene.hpp"

namespace kasumi {

// Lines across the picture, pixels right and down of its middle, from edge to edge: closer together where the encoded
// picture bends, at the horizon and around the sun. What is drawn straight between two of them is off by at most
// `tolerance` (of full scale) at the places that were looked at.
struct DomeMesh {
  std::vector<double> columns, rows;
};
DomeMesh make_dome_mesh(const SkyView& view, const SkyPainter& painter, const Direction& sun, double tolerance);

}  // namespace kasumi
