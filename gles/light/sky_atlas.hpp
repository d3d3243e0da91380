// The filtered surroundings as squares side by side in one texture, since GLES 2 guarantees neither explicit mip levels
// nor enough units: the reflection table (reflection_table.hpp), reflections from sharp to rough, and last the diffuse
// irradiance. sky_atlas.glsl reads it.
#pragma once

#include <optional>

#include "base/result.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/program.hpp"
#include "gles/light/filtered_sky.hpp"

namespace kasumi {

class SkyAtlas {
 public:
  // Filters and uploads; returns at once if it already holds these surroundings. Errors: device.
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
  glm::dvec2 unit_{1.0};  // full scale of the reflections and of the diffuse irradiance
  glm::dvec3 brightest_radiance_{0.0};
  glm::dvec3 brightest_irradiance_{0.0};
};

}  // namespace kasumi
