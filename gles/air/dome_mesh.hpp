// Where the sky's colours are computed, so that they can be interpolated linearly in between.
#pragma once

#include <vector>

#include "base/sky/dome_scene.hpp"

namespace kasumi {

// Lines across the picture, pixels right and down of its middle, from edge to edge: closer together where the encoded
// picture is strongly curved, at the horizon and around the sun. Linear interpolation between two of them errs by at
// most `tolerance` (of full scale) at the sampled places.
struct DomeMesh {
  std::vector<double> columns, rows;
};
DomeMesh make_dome_mesh(const PanoramaView& view, const DomePainter& painter, const Direction& sun, double tolerance);

}  // namespace kasumi
