#include "gles/light/sky_atlas.hpp"

#include <algorithm>

#include <glm/common.hpp>

#include "gles/gl/gl.hpp"
#include "gles/gl/texture_units.hpp"
#include "gles/light/reflection_table.hpp"

namespace kasumi {
namespace {

constexpr int kSquare = FilteredSky::kSize;
constexpr int kTable = 0, kFirstMirror = 1, kMatt = kFirstMirror + FilteredSky::kMirrors, kSquares = kMatt + 1;
static_assert(kSquares == 8 && kSquare == 65, "as sky_atlas.glsl counts them");
static_assert(kReflectionTableSize <= kSquare);

glm::vec3 brightest_of(const Image<glm::vec3>& map) {
  glm::vec3 brightest{0.0f};
  for (const glm::vec3& light : map.elements()) brightest = glm::max(brightest, light);
  return brightest;
}

}  // namespace

Result<> SkyAtlas::create() {
  texture_ = make_texture();
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, kSquares * kSquare, kSquare, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  set_filter(TextureFilter::linear);
  clamp_to_edge();
  return check_gl("making the texture of the surroundings");
}

void SkyAtlas::put(int square, const Image<glm::u8vec4>& picture) const {
  glTexSubImage2D(GL_TEXTURE_2D, 0, square * kSquare, 0, picture.width(), picture.height(), GL_RGBA, GL_UNSIGNED_BYTE,
                  picture.elements().data());
}

Result<> SkyAtlas::update(const LightAround& around, bool with_mirrors) {
  const bool enough = has_mirrors_ || !with_mirrors;
  if (from_ && enough && from_->elements() == around.radiance.elements()) return {};
  from_.reset();
  glActiveTexture(GL_TEXTURE0 + kSurfaceUnit);
  if (!texture_) {
    if (auto created = create(); !created) return created;
  }
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  if (with_mirrors && !has_table_) put(kTable, reflection_table());
  has_table_ = has_table_ || with_mirrors;

  const FilteredSky sky = filter_sky(around, with_mirrors);
  const glm::vec3 radiance = brightest_of(around.radiance), matt = brightest_of(sky.matt);
  const auto unit_of = [](const glm::vec3& brightest) {
    return std::max({brightest.r, brightest.g, brightest.b, 1e-30f});
  };
  const auto put_light = [&](int square, const Image<glm::vec3>& light, float unit) {
    Image<glm::u8vec4> bytes(light.width(), light.height());
    std::ranges::transform(light.elements(), bytes.elements().begin(),
                           [&](const glm::vec3& texel) { return in_bytes(texel, unit); });
    put(square, bytes);
  };
  if (with_mirrors)
    for (int level = 0; level < FilteredSky::kMirrors; ++level)
      put_light(kFirstMirror + level, sky.mirrors[static_cast<std::size_t>(level)], unit_of(radiance));
  put_light(kMatt, sky.matt, unit_of(matt));
  if (auto uploaded = check_gl("uploading the surroundings"); !uploaded) return uploaded;

  has_mirrors_ = with_mirrors;
  from_ = around.radiance;
  unit_ = {unit_of(radiance), unit_of(matt)};
  brightest_radiance_ = radiance;
  brightest_irradiance_ = kPi * glm::dvec3(matt);
  return {};
}

void SkyAtlas::bind(const Program& program, int unit) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<unsigned>(unit));
  glBindTexture(GL_TEXTURE_2D, texture_.name());
  program.set("sky_atlas", unit);
  program.set("sky_unit", unit_);
}

}  // namespace kasumi
