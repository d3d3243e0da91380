// The scene camera's half of the pipeline: frames and today's air in, pictures with the building out.
#pragma once

#include <future>
#include <memory>
#include <optional>
#include <utility>

#include "base/clock.hpp"
#include "gles/gl/context.hpp"
#include "pipeline/show/scene/building_layer.hpp"
#include "pipeline/show/scene/frame_upload.hpp"
#include "pipeline/show/scene/surroundings_watch.hpp"
#include "pipeline/site/visitor/building_view.hpp"

namespace kasumi {

// What the drawn building depends on, besides its background.
struct BuildingLook {
  std::uint64_t layer = 0;  // as BuildingLayer::drawn() counts
  AirlightGrid measured;
  SensorNoise noise;
  std::uint64_t passers = 0;  // changes with the outline of those in the picture; 0: none
};

struct CompositorInputs;  // compositor_making.hpp

// Belongs to the thread of its GL context. When that context is lost, a new compositor with the same model
// and the old one's air() continues seamlessly.
class Compositor {
 public:
  // Sets up everything that never changes. `model` is used only here; `prepared`: null: made here. Errors: bad_input
  // (model, mask), device.
  static Result<Compositor> create(GlContext& context, const Installation& installation, const Model& model,
                                   SceneAir air, const RendererOptions& renderer = {},
                                   std::shared_ptr<const CompositorInputs> prepared = nullptr);
  static Result<Compositor> create(GlContext& context, const Installation& installation, const Model& model,
                                   AirRendering options);
  // Reads the installation's model first.
  static Result<Compositor> create(GlContext& context, const Installation& installation, AirRendering options);

  // Draws the frame with the building under the report's air. Errors: bad_input (a frame without a picture: it is not
  // drawn and the caller keeps the last one), device.
  Result<> draw(const Frame& frame, const SkyReport& sky, const DrawTarget& target);
  // The same for a frame that another thread has decoded.
  Result<> draw(const FrameMetadata& metadata, const DecodedPicture& picture, const SkyReport& sky,
                const DrawTarget& target);
  // The same into memory, where the processor mixes the pictures; it stays until the next call. Errors: as draw().
  Result<const Image<glm::u8vec4>*> mix(const FrameMetadata& metadata, const DecodedPicture& picture,
                                        const SkyReport& sky);
  bool processor_mixes() const { return renderer_.processor_mixes(); }
  // Draws the camera's picture alone, while the sun's position is unknown.
  Result<> draw_without_object(const DecodedPicture& picture, const DrawTarget& target);
  // For a display that lays the building over the camera's picture by itself: as draw() and draw_without_object(), but
  // the frame, which must be in a driver's buffer, is only taken. draw_again() draws it. Errors: as draw().
  Result<> take(const FrameMetadata& metadata, const DecodedPicture& picture, const SkyReport& sky);
  Result<> take_without_object(const DecodedPicture& picture);
  const ExternalPicture& camera_buffer() const { return frame_.camera_buffer(); }  // of the frame taken last
  std::optional<BuildingLook> look() const;  // of the same; empty: it has no building
  PixelBox object_box() const { return renderer_.object_box(); }
  PixelBox drawn_box() const { return renderer_.drawn_box(); }
  bool has_matte() const { return renderer_.has_matte(); }
  // As Renderer::draw_for_plane(), over that frame. Needs a look.
  Result<> draw_for_plane(const DrawTarget& target);
  // Draws the last picture again, for a display that keeps running while the camera is gone. A picture that still lies
  // in the driver's buffer is copied first, which releases the buffer. Errors: bad_input (nothing has been drawn yet),
  // device.
  Result<> draw_again(const DrawTarget& target);

  // As Renderer::set_bare(): from the next picture that is drawn, not those for planes.
  void set_bare(double share) { renderer_.set_bare(share); }

  // From the next picture that is drawn: what is dimmed at once, what needs another layer once that is drawn.
  void set_view(BuildingView view) { view_ = view; }
  // The view that the layer shows by now.
  BuildingView shown_view() const {
    const auto drawn = layer_.view();
    return drawn == BuildingView::live && view_ == BuildingView::alone ? view_ : drawn;
  }

  // For when the camera is gone. The last picture is copied first, if it lies in one of its buffers. Errors: device.
  Result<> drop_camera_buffers();
  // Before the first frame: draws the building's layer under `sky` for pictures of that layout, in pieces between which
  // others may draw. The first frame then needs none of its own, unless the sky is another by then. Errors: device.
  Result<> begin_layer(const SkyReport& sky, PixelLayout layout);
  Result<bool> continue_layer() { return layer_.go_on(renderer_); }  // true: it is drawn
  // Draws that layer over a grey picture, so that every program is compiled and what cannot be drawn is known; leaves no
  // trace in the air. Errors: device.
  Result<> rehearse(PixelLayout layout, const DrawTarget& target);

  // From now on a picture waits for nothing that takes long, but the first for what it cannot do without: the layer is
  // redrawn in slices, a few milliseconds of `clock` a picture, while the old one is shown; somebody else measures the
  // horizon, and computes light and air of the layer. `clock` must outlive it.
  void go_live(const Clock& clock) { clock_ = &clock; }
  void adopt(const HorizonAnswer& answer);
  void adopt(LayerAnswer answer) { layer_.adopt(std::move(answer)); }

  // Whether the next picture need not wait until a layer is drawn.
  bool has_layer_for(const SkyReport& sky) const { return layer_.is_at_hand(air_.conditions(sky)); }
  std::optional<LayerOfBefore> layer_to_keep() const { return layer_.to_keep(renderer_); }

  const SceneAir& air() const { return air_; }
  // Each has its question, to be answered by somebody else.
  BuildingLayer& layer() { return layer_; }
  SurroundingsWatch& around() { return around_; }
  const SurroundingsWatch& around() const { return around_; }
  // How frames reached the GPU: copied, or read in the driver's buffers. Such a buffer stays in use until the next
  // frame is drawn and the display has replaced the picture (Display::show() holds it), or until draw_again(). The
  // GPU holds those it has seen until drop_camera_buffers().
  FrameCounts frames() const { return renderer_.frames(); }
  const std::vector<std::string>& notes() const { return renderer_.notes(); }

 private:
  friend class CompositorMaking;
  Compositor(Renderer renderer, SceneAir air, const Installation& installation)
      : renderer_(std::move(renderer)),
        air_(std::move(air)),
        frame_(installation.scene.width, installation.scene.height),
        around_(installation),
        encoding_(installation.scene.yuv_encoding),
        quality_(installation.scene_quality),
        white_balance_(installation.scene.white_balance),
        site_(installation.site),
        width_(installation.scene.width),
        height_(installation.scene.height) {}
  Result<> follow(const FrameMetadata& metadata, const DecodedPicture& picture, const SkyReport& sky);
  Result<> show(const DrawTarget& target);
  bool dims() const { return is_dimmed(clock_ ? shown_view() : view_); }
  bool is_in_other_light() const;  // the view that is wanted, than that of now
  LayerConditions under_view(const SceneConditions& now, const ObjectDetail& detail, const SkyReport& sky) const;
  AirlightGrid light_of_view(AirlightGrid measured, const SceneConditions& now);

  std::future<void> filters_;  // of the sky, on their way
  Renderer renderer_;
  SceneAir air_;
  FrameUpload frame_;
  BuildingLayer layer_;
  SurroundingsWatch around_;
  YuvEncoding encoding_;
  ImageQuality quality_;
  glm::dvec3 white_balance_;
  Site site_;
  BuildingView view_ = BuildingView::live;
  struct HourTint {
    std::uint64_t layer = 0;
    glm::dvec3 factor{1.0};
  };
  HourTint tint_;                         // of the layer of another hour
  int width_, height_;                    // of the camera's pictures
  const Clock* clock_ = nullptr;          // live; null: everything is done at once
  SensorNoise noise_;                     // of the picture drawn last
  std::optional<AirlightGrid> measured_;  // of the picture drawn last; empty: it has no building
};

}  // namespace kasumi
