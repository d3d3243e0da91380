#include "gles/object/foreground.hpp"

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {

Result<Foreground> Foreground::upload(const Image<std::uint8_t>& mask, const GlInfo& info) {
  if (mask.width() > info.max_texture_size || mask.height() > info.max_texture_size)
    return fail(FaultKind::bad_input, "foreground mask of {} x {} pixels: this driver supports at most {}",
                mask.width(), mask.height(), info.max_texture_size);
  Foreground made;
  made.size_ = {mask.width(), mask.height()};
  made.texture_ = make_texture();
  made.bind();
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_LUMINANCE, mask.width(), mask.height(), 0, GL_LUMINANCE, GL_UNSIGNED_BYTE,
               mask.elements().data());
  set_filter(TextureFilter::nearest);
  clamp_to_edge();
  if (auto uploaded = check_gl("uploading the foreground mask"); !uploaded) return fail(uploaded.error());
  return made;
}

void Foreground::bind() const {
  glActiveTexture(GL_TEXTURE0 + kForegroundUnit);
  glBindTexture(GL_TEXTURE_2D, texture_.name());
}

}  // namespace kasumi
