// Radiance from all directions around a place as an octahedral map (Engelhardt and Dachsbacher 2008). The zenith lies
// in the middle, the horizon is the inscribed diamond, and the nadir lies in all four corners. The first and last
// texels of rows and columns lie exactly on the map's edge, whose halves are folded onto each other.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/geometry.hpp"
#include "base/image.hpp"

namespace kasumi {

// Map coordinates run from -1 to 1 each way: x east, y north.
glm::dvec2 place_on_map(const Direction& direction);
Direction direction_on_map(const glm::dvec2& place);  // also up to 1 beyond the edges

struct LightAround {
  // A texel at the horizon spans 3 deg of azimuth by 3 to 4 deg of elevation. Even, so that the horizon passes between
  // texel centres.
  static constexpr int kSize = 64;
  Image<glm::vec3> radiance{kSize, kSize};  // rows from south to north; mean over each texel

  static glm::dvec2 place_of(int x, int y) { return 2.0 * glm::dvec2{x, y} / (kSize - 1.0) - 1.0; }
};

struct MapTexel {
  Direction direction;
  double solid_angle;
};
// One per map element, in the same order; their solid angles sum to 4 pi except for discretisation.
const std::vector<MapTexel>& map_texels();

// The map of a radiance given for all directions, which may be discontinuous at the horizon.
LightAround light_around_of(const std::function<glm::dvec3(const Direction&)>& radiance);
// Irradiance on a surface with this normal: the integral of radiance times cosine; pi L for a uniform radiance L.
glm::dvec3 irradiance(const LightAround& light, const Direction& normal);

}  // namespace kasumi
