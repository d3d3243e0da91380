#include "gles/object/scene_depth.hpp"

#include <algorithm>
#include <cmath>

#include <glm/gtc/type_precision.hpp>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

// As in scene_depth.glsl: whole centimetres in three bytes; the largest value means unknown.
constexpr double kPerMetre = 100.0;
constexpr std::uint32_t kNothing = 0xFFFFFF;

glm::u8vec3 texel_of(float depth_m) {
  const double steps = std::round(kPerMetre * double(depth_m));
  const bool known = std::isfinite(depth_m) && depth_m > 0.0f && steps < kNothing;
  const auto value = known ? static_cast<std::uint32_t>(steps) : kNothing;
  return {value >> 16, value >> 8 & 0xFF, value & 0xFF};
}

}  // namespace

Result<SceneDepth> SceneDepth::upload(const Image<float>& depth_m, const GlInfo& info) {
  if (depth_m.width() > info.max_texture_size || depth_m.height() > info.max_texture_size)
    return fail(FaultKind::bad_input, "depth map of {} x {} pixels: this driver supports at most {}", depth_m.width(),
                depth_m.height(), info.max_texture_size);
  Image<glm::u8vec3> texels(depth_m.width(), depth_m.height());
  std::ranges::transform(depth_m.elements(), texels.elements().begin(), texel_of);
  SceneDepth made(make_texture(), {depth_m.width(), depth_m.height()});
  glActiveTexture(GL_TEXTURE0 + kForegroundUnit);
  glBindTexture(GL_TEXTURE_2D, made.texture_.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB, texels.width(), texels.height(), 0, GL_RGB, GL_UNSIGNED_BYTE,
               texels.elements().data());
  set_filter(TextureFilter::nearest);
  clamp_to_edge();
  if (auto uploaded = check_gl("uploading the depth map"); !uploaded) return fail(uploaded.error());
  return made;
}

void SceneDepth::bind(const Program& program, int unit) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  program.set("scene_depth", unit);
  program.set("scene_size", glm::dvec2(size_));
}

}  // namespace kasumi
