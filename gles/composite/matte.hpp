// What stands in front of the object and what is behind it, as the sure pixels of the camera's picture show them, for
// pixels that the mask leaves open (matte.glsl). Found again in every picture, in a texture of few texels.
#pragma once

#include "base/image.hpp"
#include "base/result.hpp"
#include "gles/composite/matte_nodes.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gpu_model/programs.hpp"
#include "gles/picture/camera_textures.hpp"
#include "gles/picture/response_table.hpp"

namespace kasumi {

class Matte {
 public:
  // nodes: not empty; picture: its size. Errors: device.
  static Result<Matte> create(const MatteNodes& nodes, const glm::ivec2& picture);
  // Reads the picture. Leaves its own framebuffer bound. Errors: device.
  Result<> follow(Programs& programs, const CameraTextures& camera, const ResponseOnGpu& response,
                  const GlTexture& dither) const;
  // Binds the nodes and sets the uniforms of matte.glsl, but not the foreground.
  void bind(const Program& program, int unit, int width, int height) const;

 private:
  Matte() = default;
  glm::ivec2 corner_px_{};
  int cell_px_ = 0, columns_ = 0, rows_ = 0;
  GlTexture taps_;  // what each node reads (matte.frag)
  GlTexture texture_;
  GlFramebuffer framebuffer_;
};

}  // namespace kasumi
