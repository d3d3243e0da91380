#include "gles/object/foreground.hpp"

#include <algorithm>
#include <vector>

#include <glm/gtc/type_precision.hpp>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

// A mask that falls from free to covered within a pixel or two shows a still edge, and its shares are those of the
// pixels; where it falls slowly, something moves, and they are a mean over time.
std::uint8_t trust_in(const Image<std::uint8_t>& mask, int x, int y) {
  constexpr int kMoves = 215, kStill = 255, kMost = 255;
  int low = 255, high = 0;
  for (int v = std::max(0, y - 1); v <= std::min(mask.height() - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(mask.width() - 1, x + 1); ++u) {
      low = std::min<int>(low, mask.at(u, v));
      high = std::max<int>(high, mask.at(u, v));
    }
  return static_cast<std::uint8_t>(std::clamp((high - low - kMoves) * kMost / (kStill - kMoves), 0, kMost));
}

}  // namespace

Result<Foreground> Foreground::upload(const Image<std::uint8_t>& mask, const GlInfo& info) {
  if (mask.width() > info.max_texture_size || mask.height() > info.max_texture_size)
    return fail(FaultKind::bad_input, "foreground mask of {} x {} pixels: this driver supports at most {}",
                mask.width(), mask.height(), info.max_texture_size);
  Foreground made;
  made.mask_ = mask;
  Image<glm::u8vec2> texels(mask.width(), mask.height());
  for (int y = 0; y < mask.height(); ++y)
    for (int x = 0; x < mask.width(); ++x)
      texels.at(x, y) = {mask.at(x, y), made.is_mixed(x, y) ? trust_in(mask, x, y) : 255};
  made.texture_ = make_texture();
  made.bind();
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_LUMINANCE_ALPHA, mask.width(), mask.height(), 0, GL_LUMINANCE_ALPHA,
               GL_UNSIGNED_BYTE, texels.elements().data());
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
