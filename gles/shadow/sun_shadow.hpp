// The sun's shadow of the object, soft by the sun's size: what 16 points spread over the sun's disc see of it, as depth
// maps side by side in one texture. A sample of the layer looks at one of them, each of a pixel's samples at another,
// so that a pixel sees the whole disc: penumbras are those of the disc for whatever stands between, without a search
// for it. Drawn when the layer is, never per frame.
#pragma once

#include "base/result.hpp"
#include "base/sky/sun_disc.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"
#include "gles/gpu_model/gpu_model.hpp"
#include "gles/gpu_model/programs.hpp"
#include "gles/gpu_model/projection.hpp"

namespace kasumi {

constexpr int kSunPoints = 16;  // as sun_maps.glsl

// The object as the middle of the sun sees it: x and y in texels of a map from the middle of the bounds, z 0..1 away
// from the sun, with an empty margin all around.
struct SunFrame {
  int texels = 0;               // along a side of one map
  glm::dmat4 from_model{1.0};   // points
  glm::dmat3 from_world{1.0};   // directions of a metre
  glm::dmat3 from_normal{1.0};  // normals of planes
  glm::dvec2 spread{};          // texels that depth 1 is moved by, seen from the disc's edge
  double texel_m = 0.0;         // the longer side of a texel
  double depth_m = 0.0;         // that depth 1 stands for
  friend bool operator==(const SunFrame&, const SunFrame&) = default;
};
// sun: unit vector towards it, world frame.
SunFrame make_sun_frame(const ModelBounds& bounds, const glm::dmat4& model_to_world, const glm::dvec3& sun, int texels);

class SunShadow {
 public:
  struct Options {
    bool packed = false;      // depth in the bytes of a colour although the driver has depth textures
    bool face_slopes = true;  // by derivatives, where the driver has them
  };
  // What this driver offers of the options.
  static Options options_for(const GlInfo& info, const Options& asked);
  // Texels that a map needs, so that none is seen larger than a pixel: a power of two, 256 .. 1024, halved by the
  // driver's limits and once more where depth is packed, which takes twice the memory (4 or 8 bytes a texel).
  static int texels_for(const GpuModel& model, const Projection& projection, const GlInfo& info,
                        const Options& options);

  // Errors: device (shaders, memory).
  static Result<SunShadow> draw(const GpuModel& model, const SunFrame& frame, const Options& options,
                                const GlInfo& info, Programs& programs);

  const SunFrame& frame() const { return frame_; }
  // Of programs that look at it.
  Defines defines() const;
  // Uniforms of sun_maps.glsl and sun_shadow.glsl, and sun_from_model; the maps to a unit.
  void bind(const Program& program, int unit) const;

 private:
  SunShadow() = default;
  SunFrame frame_;
  Options options_;
  GlTexture maps_;
};

}  // namespace kasumi
