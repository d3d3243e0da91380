// The filtered surroundings as bytes, as they lie side by side in the texture that sky_atlas.glsl reads: the reflection
// table (reflection_table.hpp), reflections from sharp to rough, and last the diffuse irradiance. Computed on the CPU in
// some ten milliseconds, the first time in some hundred; without GL, so on any thread.
#pragma once

#include <vector>

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"
#include "gles/light/filtered_radiance.hpp"

namespace kasumi {

struct AtlasSquares {
  static constexpr int kSize = FilteredRadiance::kSize;
  static constexpr int kTable = 0, kFirstMirror = 1, kMatt = kFirstMirror + FilteredRadiance::kMirrors,
                       kCount = kMatt + 1;

  std::vector<Image<glm::u8vec4>> squares;  // kCount; without mirrors all but the last are empty
  Image<glm::vec3> of;                      // the surroundings that were filtered
  bool mirrors = false;
  glm::dvec2 unit{1.0};  // full scale of the reflections and of the diffuse irradiance
  glm::dvec3 brightest_radiance{0.0};
  glm::dvec3 brightest_irradiance{0.0};
};
// `with_mirrors`: for models that reflect.
AtlasSquares atlas_squares(const LightAround& around, bool with_mirrors);
// What takes long the first time, and depends on nothing; on any thread, beside whatever else there is to do.
void prepare_atlas_squares();

}  // namespace kasumi
