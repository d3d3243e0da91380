#include "gles/gl/picture_copy.hpp"

#include <algorithm>

#include "gles/gl/egl.hpp"
#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

constexpr GLenum kCopiedFrom = 0x8CA8;  // GLES 3's, as the function's type
using CopyRows = void (*)(GLint, GLint, GLint, GLint, GLint, GLint, GLint, GLint, GLbitfield, GLenum);

CopyRows blit_framebuffer() {
  return reinterpret_cast<CopyRows>(eglGetProcAddress("glBlitFramebuffer"));
}

}  // namespace

bool PictureCopy::works(const GlInfo& info) {
  return info.software && info.es_major >= 3 && info.has("GL_EXT_texture_format_BGRA8888") &&
         blit_framebuffer() != nullptr;
}

Result<> PictureCopy::make(int width, int height, bool blue_first) {
  if (texture_ && width == width_ && height == height_ && blue_first == blue_first_) return {};
  const GLenum format = blue_first ? GL_BGRA_EXT : GL_RGBA;
  texture_ = make_texture();
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format), width, height, 0, format, GL_UNSIGNED_BYTE, nullptr);
  set_filter(TextureFilter::nearest);
  clamp_to_edge();
  framebuffer_ = make_framebuffer();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture_.name(), 0);
  if (auto complete = check_framebuffer("a picture that is copied"); !complete) return complete;
  width_ = width;
  height_ = height;
  blue_first_ = blue_first;
  return {};
}

Result<> PictureCopy::show(const Image<glm::u8vec4>& picture, const DrawTarget& target, const Letterbox& box) {
  const int width = picture.width(), height = picture.height();
  // A screen's own framebuffer has blue first, and only rows of the same order are copied as they are.
  const bool blue_first = target.framebuffer == 0;
  glActiveTexture(GL_TEXTURE0 + kPlaneUnit);
  if (auto made = make(width, height, blue_first); !made) return made;
  const glm::u8vec4* pixels = picture.elements().data();
  if (blue_first) {
    swapped_.resize(picture.elements().size());
    std::transform(pixels, pixels + swapped_.size(), swapped_.data(), [](const glm::u8vec4& p) {
      return glm::u8vec4{p.b, p.g, p.r, p.a};
    });
    pixels = swapped_.data();
  }
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width, height, blue_first ? GL_BGRA_EXT : GL_RGBA, GL_UNSIGNED_BYTE, pixels);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  glBindFramebuffer(kCopiedFrom, framebuffer_.name());
  const int first = target.top_row_first ? box.y : box.y + height, last = target.top_row_first ? box.y + height : box.y;
  blit_framebuffer()(0, 0, width, height, box.x, first, box.x + width, last, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
  return check_gl("copying a picture to the screen");
}

}  // namespace kasumi
