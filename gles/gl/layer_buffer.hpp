// A render target of the object's layer that the next pass samples.
#pragma once

#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"

namespace kasumi {

struct LayerBuffer {
  GlTexture texture;
  GlFramebuffer framebuffer;

  // RGBA in 8 bits or half floats, unfiltered, clamped to its edges. `what` names it in error messages. Errors: device.
  static Result<LayerBuffer> create(int width, int height, bool in_8_bits, const GlInfo& info, std::string_view what);
};

// Fills the viewport, for programs with square.vert or resolve.vert.
void draw_square();

}  // namespace kasumi
