// The camera's response curve for the shaders.
#pragma once

#include <glm/gtc/type_precision.hpp>
#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/result.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/program.hpp"
#include "gles/scene.hpp"

namespace kasumi {

// The texels of RESPONSE_TABLE in response.glsl. Encoded 8-bit values fall on entries exactly (255 x 4 steps).
constexpr int kResponseEntries = 1021;
Image<glm::u8vec4> response_texels(const ResponseCurve& response);

class ResponseOnGpu {
 public:
  // Errors (bad_input): a table with fewer than 2 entries, not finite, outside 0..1 or not strictly increasing; device.
  static Result<ResponseOnGpu> create(const ResponseCurve& response);

  std::string define() const;  // variant of response.glsl
  void bind(const Program& program, int unit) const;

 private:
  ResponseOnGpu() = default;
  ResponseCurve::Kind kind_ = ResponseCurve::Kind::srgb;
  GlTexture table_;
};

}  // namespace kasumi
