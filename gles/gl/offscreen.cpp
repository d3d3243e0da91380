#include "gles/gl/offscreen.hpp"

#include <EGL/egl.h>

#include <algorithm>

#include <glm/vec4.hpp>

#include "gles/gl/depth.hpp"
#include "gles/gl/gl.hpp"

namespace kasumi {
namespace {

// Multisampled renderbuffers and resolving them are core in GLES 3; many drivers return a version 3 context when 2 is
// requested.
constexpr GLenum kReadFramebuffer = 0x8CA8, kDrawFramebuffer = 0x8CA9, kMaxSamples = 0x8D57;
using StorageMultisample = void (*)(GLenum, GLsizei, GLenum, GLsizei, GLsizei);
using BlitFramebuffer = void (*)(GLint, GLint, GLint, GLint, GLint, GLint, GLint, GLint, GLbitfield, GLenum);

template <class Function>
Function core_function(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

int samples_given(const GlInfo& info, int asked) {
  if (asked <= 1 || info.es_major < 3) return 1;
  if (core_function<StorageMultisample>("glRenderbufferStorageMultisample") == nullptr ||
      core_function<BlitFramebuffer>("glBlitFramebuffer") == nullptr)
    return 1;
  GLint most = 1;
  glGetIntegerv(kMaxSamples, &most);
  return std::max(1, std::min(asked, most));
}

}  // namespace

unsigned depth_format(const GlInfo& info) {
  return info.es_major >= 3 || info.has("GL_OES_depth24") ? GL_DEPTH_COMPONENT24_OES : GL_DEPTH_COMPONENT16;
}

Result<Offscreen> Offscreen::create(const GlInfo& info, int width, int height, Depth depth, int samples) {
  if (width < 1 || height < 1 || width > info.max_texture_size || height > info.max_texture_size)
    return fail(FaultKind::bad_input, "a picture of {} x {} pixels: expected 1 .. {} each way on this driver", width,
                height, info.max_texture_size);
  Offscreen made;
  made.width_ = width;
  made.height_ = height;
  made.samples_ = samples_given(info, samples);

  const auto storage = [&](GLenum format) {
    if (made.samples_ > 1)
      core_function<StorageMultisample>("glRenderbufferStorageMultisample")(GL_RENDERBUFFER, made.samples_, format,
                                                                            width, height);
    else
      glRenderbufferStorage(GL_RENDERBUFFER, format, width, height);
  };
  if (depth == Depth::buffer) {
    made.depth_ = make_renderbuffer();
    glBindRenderbuffer(GL_RENDERBUFFER, made.depth_.name());
    storage(depth_format(info));
  }

  made.resolved_ = make_framebuffer();
  made.resolved_colour_ = make_texture();
  glBindTexture(GL_TEXTURE_2D, made.resolved_colour_.name());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glBindFramebuffer(GL_FRAMEBUFFER, made.resolved_.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, made.resolved_colour_.name(), 0);

  if (made.samples_ > 1) {
    made.drawn_ = make_framebuffer();
    made.drawn_colour_ = make_renderbuffer();
    glBindRenderbuffer(GL_RENDERBUFFER, made.drawn_colour_.name());
    storage(GL_RGBA8_OES);
    glBindFramebuffer(GL_FRAMEBUFFER, made.drawn_.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, made.drawn_colour_.name());
  }
  if (depth == Depth::buffer)
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, made.depth_.name());
  if (auto complete = check_framebuffer("the picture's framebuffer"); !complete) return fail(complete.error());
  return made;
}

DrawTarget Offscreen::target() const {
  return {samples_ > 1 ? drawn_.name() : resolved_.name(), width_, height_, true};
}

Result<Image<Rgb8>> Offscreen::read() {
  if (samples_ > 1) {
    glBindFramebuffer(kReadFramebuffer, drawn_.name());
    glBindFramebuffer(kDrawFramebuffer, resolved_.name());
    core_function<BlitFramebuffer>("glBlitFramebuffer")(0, 0, width_, height_, 0, 0, width_, height_,
                                                        GL_COLOR_BUFFER_BIT, GL_NEAREST);
  }
  return read_back({resolved_.name(), width_, height_, true});
}

Result<Image<Rgb8>> read_back(const DrawTarget& target) {
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  Image<glm::u8vec4> pixels(target.width, target.height);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, target.width, target.height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.elements().data());
  if (auto read = check_gl("reading the picture back"); !read) return fail(read.error());
  Image<Rgb8> picture(target.width, target.height);
  for (int y = 0; y < target.height; ++y)
    std::ranges::transform(pixels.row(y), pixels.row(y) + target.width,
                           picture.row(target.top_row_first ? y : target.height - 1 - y),
                           [](glm::u8vec4 p) { return Rgb8(p); });
  return picture;
}

}  // namespace kasumi
