#include "gles/composite/finished_pixels.hpp"

#include <cmath>
#include <utility>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {

// Whole pixels of the target around the covered ones of the picture.
void FinishedPixels::move_to(const TargetPlacement& shown, const PixelBox& covered) {
  clear();
  picture_ = shown.box;
  top_row_first_ = shown.top_row_first;
  covered_ = covered;
  const glm::dvec2 scale = glm::dvec2{picture_.width, picture_.height} / glm::dvec2(shown.picture);
  const double bottom = picture_.y + picture_.height;
  const double above = top_row_first_ ? picture_.y + covered.top * scale.y : bottom - covered.bottom * scale.y;
  const double below = top_row_first_ ? picture_.y + covered.bottom * scale.y : bottom - covered.top * scale.y;
  part_ = {static_cast<int>(std::floor(picture_.x + covered.left * scale.x)), static_cast<int>(std::floor(above)),
           static_cast<int>(std::ceil(picture_.x + covered.right * scale.x)), static_cast<int>(std::ceil(below))};
  const glm::dvec2 size{part_.right - part_.left, part_.bottom - part_.top};
  const double first_row = top_row_first_ ? part_.top - picture_.y : bottom - part_.top;
  const double down = top_row_first_ ? scale.y : -scale.y;
  place_ = {(part_.left - picture_.x) / scale.x, first_row / scale.y, scale.x / size.x, down / size.y};
}

Result<bool> FinishedPixels::find(const TargetPlacement& shown, const PixelBox& covered, const ObjectLook& look,
                                  const GlInfo& info, const std::function<Result<>()>& draw) {
  if (shown.box != picture_ || shown.top_row_first != top_row_first_ || covered != covered_) move_to(shown, covered);
  const bool settled = last_ && look_alike(*last_, look);
  last_ = look;
  found_ = look.noise.none() ? 0 : look.noise.pattern % kNoisePatterns;
  Kept& kept = kept_[found_];
  if (kept.look && look_alike(*kept.look, look)) return true;
  if (!settled) return false;
  const int width = part_.right - part_.left, height = part_.bottom - part_.top;
  if (kept.pixels.texture.name() == 0) {
    auto made = LayerBuffer::create(width, height, true, info, "the object's finished pixels");
    if (!made) return fail(made.error());
    kept.pixels = std::move(*made);
  }
  kept.look.reset();
  kept.in_memory = {};
  glBindFramebuffer(GL_FRAMEBUFFER, kept.pixels.framebuffer.name());
  glViewport(picture_.x - part_.left, picture_.y - part_.top, picture_.width, picture_.height);
  if (auto drawn = draw(); !drawn) return fail(drawn.error());
  kept.look = look;
  return true;
}

Result<const Image<glm::u8vec4>*> FinishedPixels::read() {
  Kept& kept = kept_[found_];
  if (kept.in_memory.empty()) {
    auto pixels = read_pixels(kept.pixels, part_.right - part_.left, part_.bottom - part_.top);
    if (!pixels) return fail(pixels.error());
    kept.in_memory = std::move(*pixels);
    kept.pixels = {};
  }
  return &kept.in_memory;
}

void FinishedPixels::bind(const Program& program) const {
  glActiveTexture(GL_TEXTURE0 + kNoiseUnit);
  glBindTexture(GL_TEXTURE_2D, kept_[found_].pixels.texture.name());
  program.set("processed", kNoiseUnit);
  program.set("processed_place", place_);
}

}  // namespace kasumi
