// Draws the camera's picture with the building under today's air in it.
//
//   auto context = open_headless_context();
//   auto renderer = Renderer::create(**context);
//   renderer->set_model(model); set_response(...); set_view(view, model_to_world(placement)); set_foreground(mask);
//   renderer->redraw_layer(appearance);              // when air, sun or pose changed
//   renderer->upload(frame);                         // each frame
//   renderer->draw(measured_airlight, target);
//
// All calls belong to the context's thread. The same inputs and driver give the same bits.
//
// Lens distortion and density-weighted path lengths are exact at vertices and linear between them: a triangle of size L
// at distance R has its range off by L^2 / (8 R) at most, and its edges stay straight. Build models of triangles no
// larger than some hundredths of the picture where the lens distorts.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <glm/gtc/type_precision.hpp>
#include <glm/mat4x4.hpp>

#include "base/image.hpp"
#include "base/jpeg_steps.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/target.hpp"
#include "gles/model/model.hpp"
#include "gles/picture/external_picture.hpp"
#include "gles/scene.hpp"

namespace kasumi {

struct TriangleChunks;
struct AtlasSquares;

// What comes with a new layer, besides its light and air.
struct WithLayer {
  std::optional<ObjectDetail> detail{};       // from when the layer is whole; empty: as it is
  std::shared_ptr<const AtlasSquares> sky{};  // atlas_squares() of its light; null: computed in begin_layer()
  bool soon = false;                          // software GL draws its shadow from maps half as wide: a coarse one
};

// A layer in memory, as a file may hold it. It has no pixel of the camera's.
struct KeptLayer {
  PixelBox box;
  ObjectDetail detail;
  Image<glm::u16vec4> halves;  // its texels (layer.glsl) as half floats
};

class Renderer {
 public:
  // `context` must be current and outlive the renderer. Errors: device, unsupported (shaders, limits).
  static Result<Renderer> create(GlContext& context, const RendererOptions& options = {});
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  // Each of these makes the layer stale. Errors: bad_input with all problems; device.
  // Textures larger than the driver supports are halved until they fit; notes() reports it.
  Result<> set_model(const Model& model);
  // model_to_world: model frame to world metres of the scene camera's site (see Placement).
  Result<> set_view(const SceneView& view, const glm::dmat4& model_to_world);
  // set_model() in pieces of some milliseconds, between which other renderers of this context may draw. `model` must
  // outlive them; `chunks`: the model's; null: it is cut here. After an error nothing more may be called.
  Result<> begin_model(const Model& model, std::shared_ptr<const TriangleChunks> chunks = nullptr);
  Result<bool> continue_model();  // true: it is set

  // Scene camera's size; 0 where something stands in front of the object, 255 where nothing does, in between where it
  // covers a part of the pixel, or sways: how much of it is found in every picture (physics 13). Blurred as the scene
  // camera blurs (standard deviation of a Gaussian, up to kWidestPointSpread_px). An empty image: nothing stands in
  // front.
  Result<> set_foreground(const Image<std::uint8_t>& mask, double point_spread_px = 0.0);
  // Scene camera's size: the planar depth (along the optical axis, metres) of the real surface that each pixel sees, 0
  // where unknown: parts of the object behind it are not drawn. An empty image: no surfaces. Not used on drivers with
  // only the eight texture units of GLES 2; notes() reports it.
  Result<> set_scene_depth(const Image<float>& depth_m);
  // The camera's blur, sharpening and JPEG blocks; none by default. The object's box grows by its spread. Blocks need
  // high precision in fragment shaders, and the JPEG's steps with each uploaded picture.
  Result<> set_detail(const ObjectDetail& detail);

  // The scene camera's response. Does not make the layer stale.
  Result<> set_response(const ResponseCurve& response);

  // The model's memory on the GPU: buffers and textures with all their levels.
  std::size_t model_bytes() const;

  // Where the object can appear; empty when it is out of the picture. The grids of airlight need to be valid only here.
  PixelBox object_box() const;
  PixelBox object_box(const ObjectDetail& detail) const;  // and where it could with this one
  bool reflects() const;                                  // the model does: atlas_squares() are needed with mirrors

  // Draws the object into the cached layer. Needs a model and a view. Takes long (supersampling); the result stays
  // valid for every exposure, that is for every measured airlight.
  Result<> redraw_layer(const ObjectAppearance& appearance);
  // The same in pieces of some milliseconds on a fast GPU: a map of the shadow, a tile of the layer. draw() shows the
  // layer of before until the new one is whole.
  Result<> begin_layer(const ObjectAppearance& appearance, const WithLayer& with = {});
  // Draws a piece, and further ones as long as `time_is_left`, waiting for the GPU after each. true: the layer is drawn.
  Result<bool> continue_layer(const std::function<bool()>& time_is_left = {});
  // Of the layer begun last.
  bool has_coarse_shadow() const;

  // The cached layer: premultiplied N = rho Gamma + 1 - Gamma in rgb, coverage in a (physics 6), one element per pixel
  // of object_box(). For tests and masks.
  Result<Image<glm::vec4>> read_layer();

  // The cached layer for restore_layer(), where the processor mixes and the driver has half floats; empty: none.
  std::optional<KeptLayer> layer_to_keep() const;
  // In the place of a layer that is drawn, and as if it were. Needs a model and a view. Errors: bad_input (another box,
  // impossible values), device.
  Result<> restore_layer(const KeptLayer& kept);

  // The camera's picture, of the view's size (others are refused with bad_input, keeping the last one). Its planes are
  // not needed after this returns.
  // `jpeg`: of the JPEG that it was decoded from; null: none.
  Result<> upload(const PictureView& frame, std::shared_ptr<const JpegSteps> jpeg = nullptr);
  // The same without a copy: the GPU reads the driver's buffer, which must keep the picture until the frame drawn from
  // it has been replaced on the display. Errors: unsupported (upload it instead; reported once in notes(), and
  // remembered for pictures of that kind), bad_input (planes beyond the buffer).
  Result<> import_frame(const ExternalPicture& frame);
  // For when the camera is gone: its driver frees no memory that the GPU still holds. Upload a picture before that was
  // imported last.
  void drop_camera_buffers();
  FrameCounts frames() const;

  // The uploaded picture with the cached layer in it. `measured`: airlight in the camera's light, full scale = 1.
  // Without a layer (no model, nothing redrawn yet): the camera's picture alone. The object gets `noise`, pixels
  // without it pass unchanged. Errors: bad_input (grid, noise), device.
  Result<> draw(const AirlightGrid& measured, const DrawTarget& target, const SensorNoise& noise = {});
  // From the next draw() on, so much of the target's width, from its left edge on, shows the camera's picture alone:
  // 0..1, and 0 until this is called. The GPU draws no pixel twice; where the processor mixes, both pictures are uploaded.
  void set_bare(double share);

  // Whether the processor mixes the pictures (RendererOptions::mixing); draw() then only shows what it has mixed. The
  // GPU still draws the layer, and the pixels that it covers when their light has changed.
  bool processor_mixes() const;
  // What draw() would show, in memory; alpha means nothing. It stays until the next call. Errors: as draw(); unsupported
  // (the GPU mixes).
  Result<const Image<glm::u8vec4>*> mix(const AirlightGrid& measured, const SensorNoise& noise = {});
  Result<const Image<glm::u8vec4>*> mix_background();  // the uploaded picture alone

  // Passers before the object in the picture uploaded last, for draw() and draw_for_plane(); without pixels: none.
  // Errors: bad_input (larger than the driver's textures), device.
  Result<> set_in_front(const InFront& passers);

  // For a display that lays one picture over another by itself: the object alone, premultiplied and encoded, which over
  // the uploaded picture gives what draw() gives, and over a later one follows its light but not its leaves. `target`
  // is the object_box()'s, top row first; it is transparent outside drawn_box(). Needs a layer. Errors: as draw().
  Result<> draw_for_plane(const AirlightGrid& measured, const DrawTarget& target, const SensorNoise& noise = {});
  // The pixels that the layer changes; empty: none, or no layer.
  PixelBox drawn_box() const;
  // The foreground leaves pixels of the object open: what is to be seen of it changes with every picture.
  bool has_matte() const;

  // One pass without a layer, for a view that moves every frame: object first, then the picture behind it. Edges are
  // smoothed only by the target's multisampling; noise, set_detail and set_scene_depth have no effect, and the
  // foreground is mixed as its mask says. The target needs a depth buffer.
  // Airlight and horizon are evaluated at vertices. See-through surfaces are blended in encoded values, since the
  // background is already drawn. Inside surfaces the result is within 2/255 of draw().
  Result<> draw_moving(const ObjectAppearance& appearance, const AirlightGrid& measured, const DrawTarget& target,
                       HazeDetail detail = HazeDetail::per_vertex);

  // The uploaded picture alone.
  Result<> draw_background(const DrawTarget& target);

  const std::vector<std::string>& notes() const;  // adaptations to this driver, for the log

 private:
  struct State;
  explicit Renderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kasumi
