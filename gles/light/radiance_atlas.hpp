// The filtered surroundings (atlas_squares.hpp) as squares side by side in one texture, since GLES 2 guarantees neither
// explicit mip levels nor enough units. sky_atlas.glsl reads it.
#pragma once

#include <optional>

#include "base/result.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gl/program.hpp"
#include "gles/light/atlas_squares.hpp"

namespace kasumi {

class RadianceAtlas {
 public:
  // Uploads `prepared` where it is of these surroundings, else filters them itself; returns at once if it already holds
  // them. `prepared` may be null. Errors: device.
  Result<> update(const LightAround& around, bool with_mirrors, const AtlasSquares* prepared = nullptr);
  void bind(const Program& program, int unit) const;

  // Of all directions and normals, per channel.
  const glm::dvec3& brightest_radiance() const { return brightest_radiance_; }
  const glm::dvec3& brightest_irradiance() const { return brightest_irradiance_; }

 private:
  Result<> create();

  GlTexture texture_;
  bool has_mirrors_ = false;
  std::optional<Image<glm::vec3>> from_;
  glm::dvec2 unit_{1.0};  // as AtlasSquares::unit
  glm::dvec3 brightest_radiance_{0.0};
  glm::dvec3 brightest_irradiance_{0.0};
};

}  // namespace kasumi
