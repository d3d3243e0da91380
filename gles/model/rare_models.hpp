// What compressed models are packed in: Draco's meshes, meshoptimizer's buffers, pictures of WebP and Basis Universal;
// and meshoptimizer's simplification. Kiosks rarely meet them, and their decoders read what strangers made, so they stand
// in a module beside the program, loaded at the first such model. For this room's sources only.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/result.hpp"

namespace kasumi {

// An attribute of a Draco mesh that a glTF asks for.
struct DracoAttribute {
  std::uint32_t id = 0;       // its number in the stream
  int components = 0;         // 1 .. 4
  float full = 0.0f;          // whole numbers are divided by this; 0: they stay as they are
  std::vector<float> values;  // out: `components` for each vertex
};
struct DracoMesh {
  std::size_t vertices = 0;
  std::vector<std::uint32_t> indices;  // three per triangle, below `vertices`
};
struct DracoLimits {
  std::size_t triangles, vertices;
  std::size_t bytes;  // of all attributes together, unpacked
};

// One compressed buffer view (EXT_meshopt_compression): count elements of `stride` bytes each.
struct MeshoptBuffer {
  std::string mode;    // ATTRIBUTES, TRIANGLES, INDICES
  std::string filter;  // "", NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL, COLOR
  std::size_t count = 0, stride = 0;
};

class RareModels {
 public:
  virtual ~RareModels() = default;
  // Errors (bad_input, without the file's name): damaged, more than the limits, far more than so few bytes can hold (all
  // three before anything is taken for them), no such attribute.
  virtual Result<DracoMesh> draco_mesh(std::span<const std::uint8_t> stream, std::span<DracoAttribute> attributes,
                                       const DracoLimits& limits) const = 0;
  // count * stride bytes. Errors (bad_input): damaged, strides that its mode does not have, far more than so few bytes
  // can hold, more than `most` bytes.
  virtual Result<std::vector<std::uint8_t>> meshopt_view(std::span<const std::uint8_t> stream,
                                                         const MeshoptBuffer& view, std::size_t most) const = 0;
  // The caller has checked its size (base/picture_header.hpp): width x height is expected. Errors (bad_input): damaged,
  // a film, of another size.
  virtual Result<Image<glm::u8vec4>> webp_picture(std::span<const std::uint8_t> file, int width, int height) const = 0;
  // The same for the largest level of a KTX2 of Basis Universal (ETC1S in BasisLZ, UASTC plain or in Zstandard). Errors
  // (bad_input): damaged, another kind of KTX2, layers, faces, depth.
  virtual Result<Image<glm::u8vec4>> ktx2_picture(std::span<const std::uint8_t> file, int width, int height) const = 0;
  // Fewer triangles of the same vertices, whose surface lies within about `error` of the given one. Vertices at one place
  // stay together; where they differ in texture or normal, the seam stays.
  virtual std::vector<std::uint32_t> simplified(std::span<const glm::vec3> positions,
                                                std::span<const std::uint32_t> indices, float error) const = 0;
};

// Any thread may call it. Errors: unsupported (the module is not there, or a library that it needs is not).
Result<const RareModels*> rare_models();

}  // namespace kasumi
