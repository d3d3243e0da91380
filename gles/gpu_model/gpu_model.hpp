// The model on the GPU, split into chunks with 16-bit indices. 32-bit indices would not help, because a tile of the
// picture draws only the chunks it shows.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/result.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/surface_texture.hpp"
#include "gles/gpu_model/gpu_material.hpp"
#include "gles/gpu_model/programs.hpp"
#include "gles/gpu_model/projection.hpp"
#include "gles/gpu_model/triangle_chunks.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

class GpuModel {
 public:
  // BLOCKS until all of it is there; ModelUpload does it in pieces. Errors: bad_input (see check(Model)), device.
  static Result<GpuModel> upload(const Model& model, const GlInfo& info, bool force_encoded_textures,
                                 std::vector<std::string>& notes);

  const ModelBounds& bounds() const { return bounds_; }  // of the object
  const ModelBounds& bounds_with_ground() const { return bounds_with_ground_; }
  bool has_ground() const { return !ground_.empty(); }
  bool has_blended() const { return !see_through_.triangles.empty(); }
  const std::vector<ModelMaterial>& materials() const { return materials_; }
  std::size_t bytes() const { return bytes_; }  // of buffers and textures on the GPU

  // Finds each chunk's pixels and sorts see-through triangles, farthest first. Returns the bounding box of all.
  PixelBox look_from(const Projection& projection);

  enum class Which { solid, blended, ground };
  // The box around those pixels of `window` that are at most `margin_px` from the box of a chunk of this kind.
  PixelBox box_within(Which which, const PixelBox& window, int margin_px) const;

  // Draws the solid or the see-through chunks that touch `window` (all when it is empty) with the object program under
  // `variant`, or those of the ground with the ground program; `set_uniforms` gets each program once it is in use.
  Result<> draw(Which which, Programs& programs, const Defines& variant, const SurfaceUnits& units,
                const PixelBox& window, const std::function<void(const Program&)>& set_uniforms) const;
  // Draws the shadow casters with the sun map's program: solid chunks, both sides, with masked materials cut out.
  // See-through surfaces cast no shadow.
  Result<> draw_shadow(Programs& programs, const Defines& variant,
                       const std::function<void(const Program&)>& set_uniforms) const;

 private:
  struct Chunk {
    int material = 0;
    GlBuffer vertices;
    GlBuffer indices;
    std::vector<glm::vec3> positions;
    std::vector<std::uint16_t> index_list;
    PixelBox box;
  };
  struct SeeThroughTriangle {
    int material = 0;
    std::uint32_t part = 0;
    std::array<std::uint32_t, 3> corners{};
    double depth_m = 0.0;
  };
  // Kept on the CPU, because the drawing order depends on the view.
  struct SeeThrough {
    std::vector<GpuVertex> vertices;
    std::vector<SeeThroughTriangle> triangles;
    std::vector<Chunk> chunks;
  };
  friend class ModelUpload;

  void add(const TriangleChunk& chunk, std::vector<Chunk>& chunks);
  void add_see_through(const Model& model);
  void sort_see_through(const Projection& projection);
  static Chunk make_chunk(int material, std::span<const GpuVertex> vertices, std::vector<std::uint16_t> index_list);
  static void begin_chunks(bool write_depth);
  static void end_chunks();
  void draw_chunk(const Chunk& chunk) const;

  const std::vector<Chunk>& chunks_of(Which which) const;

  std::vector<Chunk> solid_;
  std::vector<Chunk> ground_;
  SeeThrough see_through_;
  std::vector<ModelMaterial> materials_;
  std::vector<SurfaceTexture> textures_;
  ModelBounds bounds_;
  ModelBounds bounds_with_ground_;
  std::size_t bytes_ = 0;
  bool software_ = false;            // GL
  mutable std::size_t waiting_ = 0;  // corners of triangles given to it
};

// Puts a model on the GPU in pieces of a few megabytes, between which the thread may draw.
class ModelUpload {
 public:
  // `model` and `notes` must outlive it; `chunks`: the model's; null: it is cut here. Errors: bad_input.
  static Result<ModelUpload> begin(const Model& model, std::shared_ptr<const TriangleChunks> chunks, const GlInfo& info,
                                   bool force_encoded_textures, std::vector<std::string>& notes);
  // true: it is whole. Errors: device.
  Result<bool> step();
  GpuModel take() { return std::move(made_); }

 private:
  ModelUpload(const Model& model, const GlInfo& info, std::vector<std::string>& notes)
      : model_(&model), info_(&info), notes_(&notes) {}
  Result<bool> texture_step();

  const Model* model_;
  const GlInfo* info_;
  std::vector<std::string>* notes_;
  bool force_encoded_textures_ = false;
  std::shared_ptr<const TriangleChunks> chunks_;
  std::unique_ptr<SurfaceTextureUpload> texture_;  // the one under way
  std::size_t solid_ = 0, ground_ = 0;             // chunks that are there
  GpuModel made_;
};

}  // namespace kasumi
