// The surroundings prefiltered on octahedral maps (base/sky/light_around.hpp): reflections at increasing roughness, and
// diffuse irradiance. Computed on the CPU in some ten milliseconds.
#pragma once

#include <array>

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"
#include "base/sky/light_around.hpp"

namespace kasumi {

struct FilteredRadiance {
  static constexpr int kSize = 65;  // odd: texels lie where the octahedron has edges
  // For roughness 0, 1/6 .. 5/6 at normal incidence: radiance weighted by the GGX lobe and the cosine (split sum, Karis
  // 2013). Roughness 1 is the diffuse map, since its lobe is Lambert's.
  static constexpr int kMirrors = 6;
  std::array<Image<glm::vec3>, kMirrors> mirrors;
  Image<glm::vec3> matt;  // irradiance over pi
};
// Without mirrors, for models that do not reflect, those maps stay empty.
FilteredRadiance filter_sky(const LightAround& around, bool with_mirrors);
// The mirrors' weights, which filter_sky() otherwise computes when it is first called.
void prepare_filters();

// Light encoded in bytes so that textures can be filtered: light = unit (rgb a)^2. Accurate to 1 % in channels with at
// least a tenth of the brightest.
glm::u8vec4 in_bytes(const glm::vec3& light, float unit);

}  // namespace kasumi
