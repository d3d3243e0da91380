// Materials and pictures of a glTF. For this room's glTF sources only.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <tiny_gltf.h>
#include <glm/mat3x3.hpp>

#include "base/result.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

// The texture coordinates of a material's picture and their transform (KHR_texture_transform).
struct TexturePlacement {
  int set = 0;  // TEXCOORD_n
  glm::dmat3 transform{1.0};
  friend bool operator==(const TexturePlacement&, const TexturePlacement&) = default;
};

struct Surfaces {
  // For ModelVertex::texture and texture_2, as far as the material uses them.
  using Placements = std::array<std::optional<TexturePlacement>, 2>;
  std::vector<ModelMaterial> materials;  // one more than in the file: the last is glTF's default
  std::vector<Placements> placements;    // one per material
  std::vector<ModelTexture> textures;
};

// Decodes only pictures that materials use. Errors (bad_input): damaged or too large pictures, bad references.
Result<Surfaces> read_surfaces(const tinygltf::Model& gltf, const std::string& name, const ModelLimits& limits,
                               std::vector<std::string>& notes);

}  // namespace kasumi
