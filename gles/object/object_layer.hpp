// The object drawn once for a fixed view (physics 6): premultiplied N = rho Gamma + 1 - Gamma and coverage, averaged
// over 17 samples per pixel, blurred as by the camera, with the parts hidden by real surfaces removed.
#pragma once

#include <functional>
#include <memory>

#include <glm/gtc/type_precision.hpp>
#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/layer_buffer.hpp"
#include "gles/gpu_model/gpu_model.hpp"
#include "gles/gpu_model/programs.hpp"
#include "gles/gpu_model/projection.hpp"
#include "gles/object/ground_light.hpp"
#include "gles/object/scene_depth.hpp"
#include "gles/shadow/sun_shadow.hpp"

namespace kasumi {

class ObjectLayer {
 public:
  struct Options {
    bool in_8_bits = false;  // RGBA8 with square roots instead of half floats
    double unit = 1.0;       // 8 bits: the largest N that occurs
    bool aerial_perspective = true;
    bool fog = false;         // dims and spreads the light on the object
    bool foreground = false;  // something is bound to kForegroundUnit
    ObjectDetail detail = {};
    const SceneDepth* scene_depth = nullptr;  // null: no real surfaces
    int scene_depth_unit = 0;
    const SunShadow* shadow = nullptr;          // null: no shadow
    const GroundLight* ground_light = nullptr;  // null: the sun reaches all of the ground, and the sky as well
  };
  // How many pixels beyond its outline the object affects.
  static int margin_px(const ObjectDetail& detail);

  // `horizon` is the sky model's, per pixel. `set_appearance` sets the uniforms of light and air. Requires the dither
  // pattern in kDitherUnit. BLOCKS for all its tiles; LayerDrawing draws one at a time. Errors: device.
  static Result<ObjectLayer> draw(const GpuModel& model, const Projection& projection, const PixelBox& box,
                                  const AirlightGrid& horizon, const Options& options, const GlInfo& info,
                                  Programs& programs, const std::function<void(const Program&)>& set_appearance);

  // From its texels as half floats (layer.glsl). Errors: device.
  static Result<ObjectLayer> restore(const PixelBox& box, const Image<glm::u16vec4>& halves, const GlInfo& info);

  const PixelBox& box() const { return box_; }
  // Sets uniforms of picture.frag and binds the texture to kLayerUnit.
  void bind(const Program& program, bool smooth) const;
  // One element per pixel of the box, linear.
  Result<Image<glm::vec4>> read() const;
  // The same as they are stored (layer.glsl), in units of unit().
  Result<Image<glm::vec4>> read_texels() const;
  double unit() const { return unit_; }

 private:
  friend class LayerDrawing;
  ObjectLayer() = default;
  static Result<ObjectLayer> create(const PixelBox& box, bool in_8_bits, const GlInfo& info);
  PixelBox box_;
  bool in_8_bits_ = false;  // else half floats
  double unit_ = 1.0;
  bool filters_ = false;  // the driver can filter this texture format
  LayerBuffer buffer_;
};

// Draws a layer one tile at a time, between which the thread may draw something else.
class LayerDrawing {
 public:
  // As ObjectLayer::draw(). All references, and what `options` points to, must outlive it. Errors: device.
  static Result<LayerDrawing> begin(const GpuModel& model, const Projection& projection, const PixelBox& box,
                                    const AirlightGrid& horizon, const ObjectLayer::Options& options,
                                    const GlInfo& info, Programs& programs,
                                    std::function<void(const Program&)> set_appearance);
  LayerDrawing(LayerDrawing&&) noexcept;
  LayerDrawing& operator=(LayerDrawing&&) noexcept;
  ~LayerDrawing();

  // true: it is whole. Requires the dither pattern and the foreground in their units. Errors: device.
  Result<bool> step();
  ObjectLayer take();

 private:
  struct State;
  explicit LayerDrawing(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kasumi
