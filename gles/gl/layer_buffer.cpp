#include "gles/gl/layer_buffer.hpp"

#include "gles/gl/gl.hpp"
#include "gles/gl/program.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

constexpr GLenum kRgba16f = 0x881A, kHalfFloat = 0x140B;

GlTexture make_target_texture(int width, int height, bool in_8_bits, const GlInfo& info) {
  GlTexture texture = make_texture();
  glActiveTexture(GL_TEXTURE0 + kLayerUnit);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  if (in_8_bits)
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  else if (info.es_major >= 3)
    glTexImage2D(GL_TEXTURE_2D, 0, kRgba16f, width, height, 0, GL_RGBA, kHalfFloat, nullptr);
  else
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, width, height, 0, GL_RGBA, GL_HALF_FLOAT_OES, nullptr);
  set_filter(TextureFilter::nearest);
  clamp_to_edge();
  return texture;
}

}  // namespace

Result<LayerBuffer> LayerBuffer::create(int width, int height, bool in_8_bits, const GlInfo& info,
                                        std::string_view what) {
  LayerBuffer made{make_target_texture(width, height, in_8_bits, info), make_framebuffer()};
  glBindFramebuffer(GL_FRAMEBUFFER, made.framebuffer.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, made.texture.name(), 0);
  if (auto complete = check_framebuffer(what); !complete) return fail(complete.error());
  return made;
}

Result<> LayerBuffer::fill(const Image<glm::u16vec4>& halves, const GlInfo& info) {
  glActiveTexture(GL_TEXTURE0 + kLayerUnit);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, halves.width(), halves.height(), GL_RGBA,
                  info.es_major >= 3 ? kHalfFloat : GL_HALF_FLOAT_OES, halves.elements().data());
  return check_gl("filling a layer");
}

Result<Image<glm::u8vec4>> read_pixels(const LayerBuffer& buffer, int width, int height) {
  Image<glm::u8vec4> pixels(width, height);
  glBindFramebuffer(GL_FRAMEBUFFER, buffer.framebuffer.name());
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.elements().data());
  if (auto read = check_gl("reading pixels back"); !read) return fail(read.error());
  return pixels;
}

void draw_square() {
  draw_corners({-1, -1, 1, -1, -1, 1, 1, 1});
}

void draw_corners(const std::array<float, 8>& corners) {
  glBindBuffer(GL_ARRAY_BUFFER, 0);
  glEnableVertexAttribArray(kPosition);
  glVertexAttribPointer(kPosition, 2, GL_FLOAT, GL_FALSE, 0, corners.data());
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glDisableVertexAttribArray(kPosition);
}

}  // namespace kasumi
