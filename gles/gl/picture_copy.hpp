// Pixels of memory on a target by copies alone, for software GL: it copies rows many times as fast as it draws them.
#pragma once

#include <vector>

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/target.hpp"

namespace kasumi {

class PictureCopy {
 public:
  // Whether this context copies between framebuffers (core in GLES 3, which many drivers return when 2 is requested)
  // and does it without a GPU.
  static bool works(const GlInfo& info);
  // Unscaled, to `box`, which has the picture's size. Alpha is copied as well. Needs works(). Errors: device.
  Result<> show(const Image<glm::u8vec4>& picture, const DrawTarget& target, const Letterbox& box);

 private:
  Result<> make(int width, int height, bool blue_first);

  GlTexture texture_;
  GlFramebuffer framebuffer_;
  std::vector<glm::u8vec4> swapped_;  // blue first
  int width_ = 0, height_ = 0;
  bool blue_first_ = false;
};

}  // namespace kasumi
