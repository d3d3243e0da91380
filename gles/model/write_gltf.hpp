// Writes models as glTF: triangles where they stand, materials, pictures. What Kasumi does not draw is not in a Model.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "gles/model/model.hpp"

namespace kasumi {

struct WrittenScene {
  std::string name;
  const Model* model = nullptr;  // null: a scene without anything
};

// One self-contained file: a .glb, or with `text` a .gltf. All models are of one file, so with the same materials and
// textures; `pictures`: the textures as PNG or JPEG files. `shown`: the default scene. read_gltf() gives the same models
// but for materials and textures that nothing uses, and colours of vertices in 16 bits. Nodes become places without meshes.
std::vector<std::uint8_t> gltf_of(std::span<const WrittenScene> scenes, std::size_t shown,
                                  std::span<const std::vector<std::uint8_t>> pictures, bool text);

}  // namespace kasumi
