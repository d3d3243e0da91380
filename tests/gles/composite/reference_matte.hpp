// What the matte finds in a picture, in double precision and without the renderer's code: the same rules, pixel by
// pixel. Slow.
#pragma once

#include <glm/vec3.hpp>

#include "tests/gles/object/reference_renderer.hpp"

namespace kasumi {

struct ReferenceMatte {
  double open_share = 1.0;  // of the pixel, not covered by what stands in front
  glm::dvec3 behind{0.0};   // that share's part of the camera's light
};

// At a pixel whose mask is neither 0 nor 255.
ReferenceMatte reference_matte(const ReferenceScene& scene, const Image<Rgb8>& camera, int x, int y);

}  // namespace kasumi
