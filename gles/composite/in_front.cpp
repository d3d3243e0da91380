#include "gles/composite/in_front.hpp"

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {

Result<> PassersOnGpu::upload(const InFront& passers) {
  const glm::ivec2 size{passers.pixels.width(), passers.pixels.height()};
  const bool first = texture_.name() == 0;
  if (first) texture_ = make_texture();
  glActiveTexture(GL_TEXTURE0 + kForegroundUnit);
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  if (first || size != size_px_)
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, size.x, size.y, 0, GL_RGBA, GL_UNSIGNED_BYTE,
                 passers.pixels.elements().data());
  else
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, size.x, size.y, GL_RGBA, GL_UNSIGNED_BYTE,
                    passers.pixels.elements().data());
  // Of pixels, not between them: what is behind belongs to one pixel. Beyond its edges all is free.
  set_filter(TextureFilter::nearest);
  clamp_to_edge();
  first_px_ = {passers.left, passers.top};
  size_px_ = size;
  shown_ = true;
  return check_gl("uploading who passes before the building");
}

void PassersOnGpu::bind(const Program& program, int unit, int width, int height) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<unsigned>(unit));
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  program.set("in_front", unit);
  const glm::dvec2 size(size_px_), first(first_px_);
  program.set("in_front_place", glm::dvec4(glm::dvec2{width, height} / size, -first / size));
}

}  // namespace kasumi
