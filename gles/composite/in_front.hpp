// Passers before the object in one picture, on the GPU.
#pragma once

#include "base/result.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/program.hpp"
#include "gles/scene.hpp"

namespace kasumi {

class PassersOnGpu {
 public:
  // Not empty. Errors: device.
  Result<> upload(const InFront& passers);
  void clear() { shown_ = false; }
  bool empty() const { return !shown_; }
  // width, height: of the camera's picture.
  void bind(const Program& program, int unit, int width, int height) const;

 private:
  GlTexture texture_;
  glm::ivec2 first_px_{}, size_px_{};
  bool shown_ = false;
};

}  // namespace kasumi
