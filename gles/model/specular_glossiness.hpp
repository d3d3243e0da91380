// Older materials (KHR_materials_pbrSpecularGlossiness) as metallic-roughness ones, as the Khronos group converts them:
// where the specular colour is brighter than a dielectric's, the surface is of metal. For this room's glTF sources only.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "base/image.hpp"

namespace kasumi {

struct MetalRough {
  Image<glm::u8vec4> colour;     // sRGB encoded, with the diffuse alpha
  Image<glm::u8vec4> roughness;  // green: roughness, blue: metallic
};

// Both pictures in sRGB with linear alpha, laid alike, of any two sizes; diffuse may be empty: white. Factors linear.
MetalRough metal_rough(const Image<glm::u8vec4>& diffuse, const glm::vec4& diffuse_factor,
                       const Image<glm::u8vec4>& specular_gloss, const glm::vec3& specular_factor, float gloss_factor);

}  // namespace kasumi
