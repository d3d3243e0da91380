// The object's soft sun shadow: depth maps from 16 points spread over the sun's disc, side by side in one texture. Each
// of a pixel's samples of the layer uses another map, so that a pixel averages over the whole disc: penumbras are
// correct for any occluder without searching for it. Drawn with the layer, never per frame.
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

// The projection from the centre of the sun: x and y in texels of a map from the middle of the bounds, z 0..1 away from
// the sun, with an empty margin all around.
struct SunFrame {
  int texels = 0;               // along a side of one map
  glm::dmat4 from_model{1.0};   // points
  glm::dmat3 from_world{1.0};   // directions of a metre
  glm::dmat3 from_normal{1.0};  // normals of planes
  glm::dvec2 spread{};          // shift in texels at depth 1, seen from the disc's edge
  double texel_m = 0.0;         // the longer side of a texel
  double depth_m = 0.0;         // metres per unit of depth
  friend bool operator==(const SunFrame&, const SunFrame&) = default;
};
// sun: unit vector towards it, world frame.
SunFrame make_sun_frame(const ModelBounds& bounds, const glm::dmat4& model_to_world, const glm::dvec3& sun, int texels);

class SunShadow {
 public:
  struct Options {
    bool packed = false;      // depth in the bytes of a colour even if the driver has depth textures
    bool face_slopes = true;  // from derivatives, if the driver has them
  };
  // The options that this driver supports.
  static Options options_for(const GlInfo& info, const Options& asked);
  // The size of a map at which no texel appears larger than a pixel: a multiple of 64, 256 .. 1024; at most a half or a
  // quarter of that to fit the driver's limits, and half if depth is packed, which takes 8 bytes per texel instead of 2
  // (of 4 where the object is so deep that 16 bits of depth are too few).
  static int texels_for(const GpuModel& model, const Projection& projection, const GlInfo& info,
                        const Options& options);

  // BLOCKS for all its maps; SunShadowDrawing draws one at a time. Errors: device (shaders, memory).
  static Result<SunShadow> draw(const GpuModel& model, const SunFrame& frame, const Options& options,
                                const GlInfo& info, Programs& programs);

  const SunFrame& frame() const { return frame_; }
  // Defines for programs that sample the shadow.
  Defines defines() const;
  // Sets the uniforms of sun_maps.glsl and sun_shadow.glsl, and sun_from_model, and binds the maps.
  void bind(const Program& program, int unit) const;

 private:
  friend class SunShadowDrawing;
  SunShadow() = default;
  SunFrame frame_;
  Options options_;
  GlTexture maps_;
};

// Draws a shadow one map at a time, between which the thread may draw something else.
class SunShadowDrawing {
 public:
  // `model`, `info` and `programs` must outlive it. Errors: device.
  static Result<SunShadowDrawing> begin(const GpuModel& model, const SunFrame& frame, const SunShadow::Options& options,
                                        const GlInfo& info, Programs& programs);
  // true: it is whole. Errors: device.
  Result<bool> step();
  SunShadow take() { return std::move(made_); }

 private:
  SunShadowDrawing(const GpuModel& model, Programs& programs) : model_(&model), programs_(&programs) {}

  const GpuModel* model_;
  Programs* programs_;
  SunShadow made_;
  GlFramebuffer framebuffer_;
  GlRenderbuffer depth_;  // where the maps are packed into colours
  int drawn_ = 0;
};

}  // namespace kasumi
