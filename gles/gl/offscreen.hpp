// An offscreen framebuffer, for pictures that are written to files.
#pragma once

#include <utility>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/target.hpp"

namespace kasumi {

class Offscreen {
 public:
  enum class Depth { none, buffer };  // only the one-pass path needs it
  // samples > 1 requests multisampling, which improves edges in the one-pass path; ignored if the driver lacks it.
  // Errors: bad_input (size not in 1..GL_MAX_TEXTURE_SIZE), device.
  static Result<Offscreen> create(const GlInfo& info, int width, int height, Depth depth = Depth::none,
                                  int samples = 1);

  DrawTarget target() const;
  int samples() const { return samples_; }
  // What was drawn, without multisampling; the framebuffer is gone with it.
  GlTexture take_colour() && { return std::move(resolved_colour_); }
  // BLOCKS until everything is drawn. Rows from the top.
  Result<Image<Rgb8>> read();

 private:
  Offscreen() = default;
  int width_ = 0;
  int height_ = 0;
  int samples_ = 1;
  GlFramebuffer drawn_;  // multisampled when samples_ > 1
  GlRenderbuffer drawn_colour_;
  GlRenderbuffer depth_;  // if asked for
  GlFramebuffer resolved_;
  GlTexture resolved_colour_;
};

// What has been drawn to a target so far, rows from the top. BLOCKS until it is drawn. Errors: device.
Result<Image<Rgb8>> read_back(const DrawTarget& target);

}  // namespace kasumi
