// Draws the camera's picture with the building under today's air in it.
//
//   auto context = open_headless_context();
//   auto renderer = Renderer::create(**context);
//   renderer->set_model(model); set_response(...); set_view(view, model_to_world(placement)); set_foreground(mask);
//   renderer->redraw_layer(appearance);              // when air, sun or pose changed
//   renderer->upload(frame);                         // each frame
//   renderer->draw(measured_airlight, target);
//
// Everything happens in the context's thread. Same inputs, same driver: same bits.
//
// Lens distortion and density-weighted path lengths are exact at vertices and linear between them: a triangle of size L
// at distance R has its range off by L^2 / (8 R) at most, and its edges stay straight. Build models of triangles no
// larger than some hundredths of the picture where the lens distorts.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <glm/mat4x4.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/target.hpp"
#include "gles/model/model.hpp"
#include "gles/picture/external_picture.hpp"
#include "gles/scene.hpp"

namespace kasumi {

class Renderer {
 public:
  // `context` must be current and outlive the renderer. Errors: device, unsupported (shaders, limits).
  static Result<Renderer> create(GlContext& context, const RendererOptions& options = {});
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  // Each of these makes the layer stale. Errors: bad_input with all that is wrong; device.
  // Textures larger than the driver takes are halved until they fit; notes() tells.
  Result<> set_model(const Model& model);
  // model_to_world: model frame to world metres of the scene camera's site (see Placement).
  Result<> set_view(const SceneView& view, const glm::dmat4& model_to_world);
  // Scene camera's size; 0 where something stands in front of the object, 255 where nothing does, soft in between. An
  // empty image: nothing stands in front.
  Result<> set_foreground(const Image<std::uint8_t>& mask);
  // Scene camera's size: the planar depth (along the optical axis, metres) of the real surface that each pixel sees, 0
  // where none is known: what of the object lies behind it is not drawn. An empty image: no surfaces. A driver with no
  // more than the eight texture units of GLES 2 leaves it out; notes() tells.
  Result<> set_scene_depth(const Image<float>& depth_m);
  // How coarse the camera sees; none, at first. The object's box grows by its spread.
  Result<> set_detail(const ObjectDetail& detail);

  // The scene camera's response. Does not make the layer stale.
  Result<> set_response(const ResponseCurve& response);

  // What the model takes on the GPU, buffers and textures with all their levels.
  std::size_t model_bytes() const;

  // Where the object can appear; empty when it is out of the picture. The grids of airlight need to be good here only.
  PixelBox object_box() const;

  // Draws the object into the cached layer. Needs a model and a view. Takes long (supersampling); the result stays
  // valid for every exposure, that is for every measured airlight.
  Result<> redraw_layer(const ObjectAppearance& appearance);
  // The layer as it is: premultiplied N = rho Gamma + 1 - Gamma in rgb, coverage in a (physics 6), one element per
  // pixel of object_box(). For tests and masks.
  Result<Image<glm::vec4>> read_layer();

  // The camera's picture, of the view's size (any other is refused: bad_input, and the last one stays). Its planes may
  // go when this returns.
  Result<> upload(const PictureView& frame);
  // The same without a copy: the GPU reads the driver's buffer. It must keep the picture until what was drawn of it has
  // been replaced on the display. Errors: unsupported (upload it instead; told once in notes(), and from then on
  // answered without another try for pictures of that kind), bad_input (planes beyond the buffer).
  Result<> import_frame(const ExternalPicture& frame);
  FrameCounts frames() const;

  // The uploaded picture with the cached layer in it. `measured`: airlight in the camera's light, full scale = 1.
  // Without a layer (no model, nothing redrawn yet): the camera's picture alone. The object gets `noise`, pixels
  // without it pass unchanged. Errors: bad_input (grid, noise), device.
  Result<> draw(const AirlightGrid& measured, const DrawTarget& target, const SensorNoise& noise = {});

  // One pass without a layer, for a view that moves every frame: object first, then the picture behind it. No
  // supersampling; edges are as smooth as the target's multisampling makes them; no noise, and set_detail and
  // set_scene_depth, which are of one view, do not hold. The target needs a depth buffer.
  // Airlight and horizon are taken at vertices. See-through surfaces are blended in encoded values, since what is
  // behind them has been drawn already. Inside surfaces within 2/255 of draw().
  Result<> draw_moving(const ObjectAppearance& appearance, const AirlightGrid& measured, const DrawTarget& target,
                       HazeDetail detail = HazeDetail::per_vertex);

  // The uploaded picture alone.
  Result<> draw_background(const DrawTarget& target);

  const std::vector<std::string>& notes() const;  // what was adapted to this driver, for the log

 private:
  struct State;
  explicit Renderer(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace kasumi
