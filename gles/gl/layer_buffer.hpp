// A render target of the object's layer that the next pass samples.
#pragma once

#include <array>

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"

namespace kasumi {

struct LayerBuffer {
  GlTexture texture;
  GlFramebuffer framebuffer;

  // RGBA in 8 bits or half floats, unfiltered, clamped to its edges. `what` names it in error messages. Errors: device.
  static Result<LayerBuffer> create(int width, int height, bool in_8_bits, const GlInfo& info, std::string_view what);
  // Into a buffer of that size in half floats. Errors: device.
  Result<> fill(const Image<glm::u16vec4>& halves, const GlInfo& info);
};

// Of a buffer of that size in 8 bits, its first row first. BLOCKS until it is drawn. Errors: device.
Result<Image<glm::u8vec4>> read_pixels(const LayerBuffer& buffer, int width, int height);

// Fills the viewport, for programs with square.vert or resolve.vert.
void draw_square();
// A quadrilateral: its corners in clip coordinates, as a strip.
void draw_corners(const std::array<float, 8>& corners);

}  // namespace kasumi
