// The model on the GPU, cut into chunks that 16-bit indices can address.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "base/result.hpp"
#include "gles/model.hpp"
#include "gles/objects.hpp"
#include "gles/programs.hpp"
#include "gles/projection.hpp"
#include "gles/surface_texture.hpp"

namespace kasumi {

class GpuModel {
 public:
  // Errors: bad_input (see check(Model)), device.
  static Result<GpuModel> upload(const Model& model, const GlInfo& info, bool force_encoded_textures,
                                 std::vector<std::string>& notes);

  const ModelBounds& bounds() const { return bounds_; }
  bool has_blended() const;

  // Finds each chunk's pixels and puts see-through triangles in order, farthest first. Returns the box around all.
  PixelBox look_from(const Projection& projection);

  // Draws the solid or the see-through chunks that touch `window` (all when it is empty) with the object program under
  // `variant`; `set_uniforms` gets each program once it is in use.
  enum class Which { solid, blended };
  Result<> draw(Which which, Programs& programs, const Defines& variant, const PixelBox& window,
                const std::function<void(const Program&)>& set_uniforms) const;

 private:
  struct Chunk {
    int material = 0;
    GlBuffer vertices;
    GlBuffer indices;
    std::vector<glm::vec3> positions;
    std::vector<std::uint16_t> index_list;
    PixelBox box;
    double depth_m = 0.0;  // mean, for the order of see-through chunks
  };
  struct Triangle {  // of the model being uploaded
    std::uint32_t part = 0;
    std::uint32_t first_index = 0;
    glm::vec3 centre{};
  };
  static std::vector<Triangle> triangles_of(const Model& model, int material);
  Result<> add_split(const Model& model, int material, std::span<Triangle> triangles);
  Result<> add_chunk(const Model& model, int material, std::span<const Triangle> triangles);
  void sort_by_depth(Chunk& chunk, const Projection& projection);

  std::vector<Chunk> chunks_;
  std::vector<ModelMaterial> materials_;
  std::vector<SurfaceTexture> textures_;
  ModelBounds bounds_;
};

}  // namespace kasumi
