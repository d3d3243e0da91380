// A buffer of the object's layer: something to draw into, and to read from in the next pass.
#pragma once

#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"

namespace kasumi {

struct LayerBuffer {
  GlTexture texture;
  GlFramebuffer framebuffer;

  // RGBA in 8 bits or in half floats, unfiltered, held at its edges. `what` is for the message. Errors: device.
  static Result<LayerBuffer> create(int width, int height, bool in_8_bits, const GlInfo& info, std::string_view what);
};

// Fills the viewport, for programs with resolve.vert.
void draw_square();

}  // namespace kasumi
