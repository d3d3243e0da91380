// Light from all around a place on a small square picture: the sphere unfolded by way of an octahedron (Engelhardt and
// Dachsbacher 2008). The zenith lies in the middle, the horizon is the square that stands on its corner, the nadir lies
// in all four corners. The first and last texels of rows and columns lie on the picture's very edge, which is folded
// onto itself.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "base/geometry.hpp"
#include "base/image.hpp"

namespace kasumi {

// On the picture from -1 to 1 each way: x east, y north.
glm::dvec2 place_on_map(const Direction& direction);
Direction direction_on_map(const glm::dvec2& place);  // up to one beyond the edges, too

struct LightAround {
  // At the horizon 3 deg of azimuth by 3 to 4 deg of height. Even, so that the horizon passes between texels' middles.
  static constexpr int kSize = 64;
  Image<glm::vec3> radiance{kSize, kSize};  // rows from south to north; mean over each texel

  static glm::dvec2 place_of(int x, int y) { return 2.0 * glm::dvec2{x, y} / (kSize - 1.0) - 1.0; }
};

struct MapTexel {
  Direction direction;
  double solid_angle;
};
// As many as the map's elements, in their order; their solid angles add up to 4 pi but for the texels' steps.
const std::vector<MapTexel>& map_texels();

// Of a radiance given in all directions; it may jump at the horizon.
LightAround light_around_of(const std::function<glm::dvec3(const Direction&)>& radiance);
// On a surface that faces `normal`: the integral of radiance times cosine; pi L under an even radiance L.
glm::dvec3 irradiance(const LightAround& light, const Direction& normal);

}  // namespace kasumi
