#include "gles/light/atlas_squares.hpp"

#include <algorithm>

#include <glm/common.hpp>

#include "base/units.hpp"
#include "gles/light/reflection_table.hpp"

namespace kasumi {
namespace {

static_assert(kReflectionTableSize <= AtlasSquares::kSize);

glm::vec3 brightest_of(const Image<glm::vec3>& map) {
  glm::vec3 brightest{0.0f};
  for (const glm::vec3& light : map.elements()) brightest = glm::max(brightest, light);
  return brightest;
}

float unit_of(const glm::vec3& brightest) {
  return std::max({brightest.r, brightest.g, brightest.b, 1e-30f});
}

Image<glm::u8vec4> bytes_of(const Image<glm::vec3>& light, float unit) {
  Image<glm::u8vec4> bytes(light.width(), light.height());
  std::ranges::transform(light.elements(), bytes.elements().begin(),
                         [&](const glm::vec3& texel) { return in_bytes(texel, unit); });
  return bytes;
}

const Image<glm::u8vec4>& table() {
  static const auto made = reflection_table();
  return made;
}

}  // namespace

void prepare_atlas_squares() {
  prepare_filters();
  (void)table();
}

AtlasSquares atlas_squares(const LightAround& around, bool with_mirrors) {
  const FilteredRadiance sky = filter_sky(around, with_mirrors);
  const glm::vec3 radiance = brightest_of(around.radiance), matt = brightest_of(sky.matt);
  AtlasSquares made;
  made.squares.resize(AtlasSquares::kCount);
  if (with_mirrors) {
    made.squares[AtlasSquares::kTable] = table();
    for (std::size_t level = 0; level < sky.mirrors.size(); ++level)
      made.squares[AtlasSquares::kFirstMirror + level] = bytes_of(sky.mirrors[level], unit_of(radiance));
  }
  made.squares[AtlasSquares::kMatt] = bytes_of(sky.matt, unit_of(matt));
  made.of = around.radiance;
  made.mirrors = with_mirrors;
  made.unit = {unit_of(radiance), unit_of(matt)};
  made.brightest_radiance = radiance;
  made.brightest_irradiance = kPi * glm::dvec3(matt);
  return made;
}

}  // namespace kasumi
