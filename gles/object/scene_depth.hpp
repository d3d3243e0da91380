// The real scene's depth on the GPU, which hides parts of the object.
#pragma once

#include "base/image.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/program.hpp"

namespace kasumi {

class SceneDepth {
 public:
  // Planar depth in metres, one value per pixel of the camera's picture; 0 or not finite: unknown. Stored to a
  // centimetre, up to 167 km. Errors: bad_input (too large for the driver), device.
  static Result<SceneDepth> upload(const Image<float>& depth_m, const GlInfo& info);
  // Sets the uniforms of scene_depth.glsl except fragment_to_pixel.
  void bind(const Program& program, int unit) const;
  glm::ivec2 size() const { return size_; }

 private:
  SceneDepth(GlTexture texture, glm::ivec2 size) : texture_(std::move(texture)), size_(size) {}
  GlTexture texture_;
  glm::ivec2 size_;
};

}  // namespace kasumi
