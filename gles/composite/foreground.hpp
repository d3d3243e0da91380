// The mask of what stands in front of the object, on the GPU.
#pragma once

#include <cstdint>

#include <glm/gtc/type_precision.hpp>
#include <glm/vec2.hpp>

#include "base/image.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"

namespace kasumi {

class Foreground {
 public:
  // 0 where something stands in front, 255 where nothing does; not empty. Blurred as its camera blurs (standard
  // deviation of a Gaussian). Errors: bad_input (larger than the driver supports), device.
  static Result<Foreground> upload(const Image<std::uint8_t>& mask, double point_spread_px, const GlInfo& info);

  glm::ivec2 size() const { return {mask_.width(), mask_.height()}; }
  void bind() const;                                         // to kForegroundUnit
  const Image<std::uint8_t>& mask() const { return mask_; }  // blurred
  // The mask's free shares, with the confidence of its mixed pixels.
  const Image<glm::u8vec2>& texels() const { return texels_; }
  bool is_mixed(int x, int y) const { return mask_.at(x, y) != 0 && mask_.at(x, y) != 255; }

 private:
  Foreground() = default;
  GlTexture texture_;
  Image<glm::u8vec2> texels_;  // of the texture
  Image<std::uint8_t> mask_;
};

}  // namespace kasumi
