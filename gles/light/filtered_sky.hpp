// What surfaces make of their surroundings, each on a map of directions (base/sky/light_around.hpp): what mirrors of
// growing roughness show, and what lights a matt surface. Filtered on the CPU, some ten milliseconds.
#pragma once

#include <array>

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"
#include "base/sky/light_around.hpp"

namespace kasumi {

struct FilteredSky {
  static constexpr int kSize = 65;  // odd: texels lie where the octahedron has edges
  // Of roughness 0, 1/6 .. 5/6, seen head-on: radiance under GGX's lobe, weighted by the cosine (split sum, Karis
  // 2013). Roughness 1 is the matt surface: there the lobe is Lambert's.
  static constexpr int kMirrors = 6;
  std::array<Image<glm::vec3>, kMirrors> mirrors;
  Image<glm::vec3> matt;  // irradiance over pi
};
// Without mirrors, for models that have none, their pictures stay empty.
FilteredSky filter_sky(const LightAround& around, bool with_mirrors);

// Light in bytes, for textures that are filtered between texels: light = unit (rgb a)^2. Within 1 % in channels that
// hold a tenth of the brightest or more.
glm::u8vec4 in_bytes(const glm::vec3& light, float unit);

}  // namespace kasumi
