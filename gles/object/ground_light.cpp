#include "gles/object/ground_light.hpp"

#include <algorithm>
#include <cmath>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"
#include "gles/object/layer_tiles.hpp"

namespace kasumi {
namespace {

Result<GlTexture> share_texture(const Image<float>& shares, int unit, const GlInfo& info) {
  if (std::max(shares.width(), shares.height()) > info.max_texture_size)
    return fail(FaultKind::bad_input, "the ground's light at {} x {} points: this driver supports at most {}",
                shares.width(), shares.height(), info.max_texture_size);
  Image<std::uint8_t> texels(shares.width(), shares.height());
  std::ranges::transform(shares.elements(), texels.elements().begin(), [](float share) {
    return static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(share, 0.0f, 1.0f)));
  });
  GlTexture made = make_texture();
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, made.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexImage2D(GL_TEXTURE_2D, 0, GL_LUMINANCE, texels.width(), texels.height(), 0, GL_LUMINANCE, GL_UNSIGNED_BYTE,
               texels.elements().data());
  set_filter(TextureFilter::linear);
  clamp_to_edge();
  if (auto uploaded = check_gl("uploading the ground's light"); !uploaded) return fail(uploaded.error());
  return made;
}

}  // namespace

Result<GroundLight> GroundLight::upload(const ObjectAppearance& appearance, const glm::dmat4& model_to_world,
                                        const GlInfo& info) {
  GroundLight made;
  made.model_to_world_ = model_to_world;
  if (appearance.ground_sunlight) {
    auto texture = share_texture(appearance.ground_sunlight->share, kGroundSunlightUnit, info);
    if (!texture) return fail(texture.error());
    made.sunlight_texture_ = std::move(*texture);
    made.sunlight_ = appearance.ground_sunlight;
  }
  if (appearance.foot_shade) {
    auto texture = share_texture(appearance.foot_shade->sky_seen, kFootShadeUnit, info);
    if (!texture) return fail(texture.error());
    made.foot_texture_ = std::move(*texture);
    made.foot_shade_ = appearance.foot_shade;
  }
  return made;
}

Defines GroundLight::defines() const {
  Defines defines;
  if (sunlight_) defines.insert("GROUND_SUNLIGHT");
  if (foot_shade_) defines.insert("FOOT_SHADE");
  return defines;
}

void GroundLight::bind(const Program& program, const glm::dmat3& fragment_to_pixel) const {
  if (sunlight_) {
    glActiveTexture(GL_TEXTURE0 + kGroundSunlightUnit);
    glBindTexture(GL_TEXTURE_2D, sunlight_texture_.name());
    program.set("ground_sunlight", kGroundSunlightUnit);
    const glm::dvec2 span = sunlight_->step_px * glm::dvec2(sunlight_->share.width(), sunlight_->share.height());
    const glm::dvec2 first = sunlight_->first_px - 0.5 * sunlight_->step_px;
    program.set(
        "fragment_to_sunlight",
        affine({1.0 / span.x, 0.0, -first.x / span.x}, {0.0, 1.0 / span.y, -first.y / span.y}) * fragment_to_pixel);
  }
  if (foot_shade_) {
    glActiveTexture(GL_TEXTURE0 + kFootShadeUnit);
    glBindTexture(GL_TEXTURE_2D, foot_texture_.name());
    program.set("foot_shade", kFootShadeUnit);
    const glm::dvec2 points(foot_shade_->sky_seen.width(), foot_shade_->sky_seen.height());
    const glm::dvec2 scale = 1.0 / (points * foot_shade_->step_m);
    const glm::dvec2 first = -scale * (foot_shade_->first_m - 0.5 * foot_shade_->step_m);
    const glm::dmat4 from_world{{scale.x, 0, 0, 0}, {0, scale.y, 0, 0}, {0, 0, 1, 0}, {first, 0, 1}};
    program.set("foot_from_model", from_world * model_to_world_);
  }
}

}  // namespace kasumi
