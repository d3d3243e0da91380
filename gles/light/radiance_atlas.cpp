#include "gles/light/radiance_atlas.hpp"

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"

namespace kasumi {
namespace {

constexpr int kSquare = AtlasSquares::kSize;
static_assert(AtlasSquares::kCount == 8 && kSquare == 65, "as sky_atlas.glsl counts them");

}  // namespace

Result<> RadianceAtlas::create() {
  texture_ = make_texture();
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, AtlasSquares::kCount * kSquare, kSquare, 0, GL_RGBA, GL_UNSIGNED_BYTE,
               nullptr);
  set_filter(TextureFilter::linear);
  clamp_to_edge();
  return check_gl("making the texture of the surroundings");
}

Result<> RadianceAtlas::update(const LightAround& around, bool with_mirrors, const AtlasSquares* prepared) {
  const bool enough = has_mirrors_ || !with_mirrors;
  if (from_ && enough && from_->elements() == around.radiance.elements()) return {};
  from_.reset();
  std::optional<AtlasSquares> own;
  if (!prepared || (with_mirrors && !prepared->mirrors) || prepared->of.elements() != around.radiance.elements())
    prepared = &own.emplace(atlas_squares(around, with_mirrors));

  glActiveTexture(GL_TEXTURE0 + kSurfaceUnit);
  if (!texture_) {
    if (auto created = create(); !created) return created;
  }
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  for (std::size_t i = 0; i < prepared->squares.size(); ++i) {
    const auto& square = prepared->squares[i];
    if (!square.empty())
      glTexSubImage2D(GL_TEXTURE_2D, 0, static_cast<int>(i) * kSquare, 0, square.width(), square.height(), GL_RGBA,
                      GL_UNSIGNED_BYTE, square.elements().data());
  }
  if (auto uploaded = check_gl("uploading the surroundings"); !uploaded) return uploaded;

  has_mirrors_ = prepared->mirrors;
  from_ = around.radiance;
  unit_ = prepared->unit;
  brightest_radiance_ = prepared->brightest_radiance;
  brightest_irradiance_ = prepared->brightest_irradiance;
  return {};
}

void RadianceAtlas::bind(const Program& program, int unit) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<unsigned>(unit));
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  program.set("sky_atlas", unit);
  program.set("sky_unit", unit_);
}

}  // namespace kasumi
