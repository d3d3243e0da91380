// The filtered surroundings in one texture, squares side by side, since GLES 2 promises neither levels to choose from
// nor units for many: how much rough facets give back (reflection_table.hpp), what mirrors show from sharp to rough,
// and last what lights a matt surface. sky_atlas.glsl reads it.
#pragma once

#include <optional>

#include "base/result.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/program.hpp"
#include "gles/light/filtered_sky.hpp"

namespace kasumi {

class SkyAtlas {
 public:
  // Filters and uploads; at once where these surroundings are in it already. Errors: device.
  Result<> update(const LightAround& around, bool with_mirrors);
  void bind(const Program& program, int unit) const;

  // Of all directions and normals, per channel.
  const glm::dvec3& brightest_radiance() const { return brightest_radiance_; }
  const glm::dvec3& brightest_irradiance() const { return brightest_irradiance_; }

 private:
  Result<> create();
  void put(int square, const Image<glm::u8vec4>& picture) const;

  GlTexture texture_;
  bool has_table_ = false;
  bool has_mirrors_ = false;
  std::optional<Image<glm::vec3>> from_;
  glm::dvec2 unit_{1.0};  // of the mirrors, of the matt surface: what full scale stands for
  glm::dvec3 brightest_radiance_{0.0};
  glm::dvec3 brightest_irradiance_{0.0};
};

}  // namespace kasumi
