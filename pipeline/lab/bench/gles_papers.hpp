// The papers' layout (M Sect 6), which the renderer is measured against.
#pragma once

#include <vector>

#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/target.hpp"
#include "gles/gpu_model/gpu_model.hpp"
#include "gles/gpu_model/programs.hpp"
#include "gles/gpu_model/projection.hpp"
#include "gles/light/radiance_atlas.hpp"
#include "pipeline/lab/bench/gles_passes.hpp"
#include "pipeline/lab/bench/gles_scene.hpp"

namespace kasumi {

// The papers' layout: object to a buffer with colour and depth, camera's picture to another, then the compositing pass.
// Their fragments stay as they publish them: no response curve is undone and none applied, which costs less than
// Kasumi's.
class TwoBufferLayout {
 public:
  // `picture` is the camera's, a texture that outlives this. Errors: unsupported (no depth textures), device.
  static Result<TwoBufferLayout> create(const GlInfo& info, unsigned picture, const BenchScene& scene, GammaBy gamma);
  Result<> draw(const DrawTarget& target);

 private:
  TwoBufferLayout() = default;
  Result<> draw_object();

  BenchScene scene_;
  Projection projection_;
  DepthRange range_;
  RadianceAtlas sky_;
  Programs programs_;
  std::vector<GpuModel> model_;  // one
  GlTexture object_colour_, object_depth_, background_colour_;
  GlFramebuffer object_, background_;
  std::vector<ScreenPass> passes_;  // background, compositing
};

// A nearest-filtered texture of the picture; without pixels when `pixels` is null.
GlTexture make_picture_texture(int width, int height, const void* pixels);

}  // namespace kasumi
