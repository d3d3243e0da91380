// The scene camera's half of the pipeline: its frames and today's air in, the picture with the building out.
#pragma once

#include <memory>
#include <optional>

#include "gles/gl/context.hpp"
#include "gles/object/renderer.hpp"
#include "pipeline/scene/scene_air.hpp"

namespace kasumi {

// Belongs to the thread of its GL context. When that context is lost, a new one of the same model, and of the old one's
// air(), goes on as if nothing had happened.
class Compositor {
 public:
  // Tells the renderer what never changes. `model` is read here only. Errors: bad_input (model, mask), device.
  static Result<Compositor> create(GlContext& context, const Installation& installation, const Model& model,
                                   SceneAir air, const RendererOptions& renderer = {});
  static Result<Compositor> create(GlContext& context, const Installation& installation, const Model& model,
                                   SceneAirOptions options);
  // Reads the installation's model first.
  static Result<Compositor> create(GlContext& context, const Installation& installation, SceneAirOptions options);

  // Draws the frame with the building under the report's air. Errors: bad_input (a frame without a picture: it is not
  // drawn and the caller keeps the last one), device.
  Result<> draw(const Frame& frame, const SkyReport& sky, const DrawTarget& target);
  // The same of a frame that another thread has decoded.
  Result<> draw(const FrameMetadata& metadata, const DecodedPicture& picture, const SkyReport& sky,
                const DrawTarget& target);
  // The camera's picture alone, while nobody knows where the sun is.
  Result<> draw_without_object(const DecodedPicture& picture, const DrawTarget& target);
  // What was drawn last once more, without a frame: for a display that shows on while the camera is gone. A picture
  // that was read in the driver's buffer is copied first, once: from then on the buffer is the driver's again. Errors:
  // bad_input (nothing has been drawn yet), device.
  Result<> draw_again(const DrawTarget& target);

  const SceneAir& air() const { return air_; }
  std::uint64_t layers_drawn() const { return layers_drawn_; }
  // How frames came to the GPU: copied, or read in the driver's buffers, which then stay lent until the next frame is
  // drawn (and the display has replaced the picture: the caller's Display::show() holds them as long) or draw_again().
  FrameCounts frames() const { return renderer_.frames(); }
  const std::vector<std::string>& notes() const { return renderer_.notes(); }

 private:
  Compositor(Renderer renderer, SceneAir air, const Installation& installation)
      : renderer_(std::move(renderer)),
        air_(std::move(air)),
        encoding_(installation.scene.yuv_encoding),
        quality_(installation.scene_quality),
        white_balance_(installation.scene.white_balance) {}
  Result<> pass_to_gpu(const DecodedPicture& picture);
  Result<> update_detail(PixelLayout layout, double haze_blur_px);
  Result<> show(const DrawTarget& target);

  Renderer renderer_;
  SceneAir air_;
  YuvEncoding encoding_;
  ImageQuality quality_;
  glm::dvec3 white_balance_;
  ObjectDetail detail_;
  std::optional<SceneConditions> layer_;  // the air the cached layer was drawn under
  std::uint64_t layers_drawn_ = 0;
  bool drawn_ = false;
  std::optional<DecodedPicture> lent_;    // the picture drawn last, while it lies in the driver's buffer
  SensorNoise noise_;                     // of the picture drawn last
  std::optional<AirlightGrid> measured_;  // under the picture drawn last; empty: it was the camera's alone
};

}  // namespace kasumi
