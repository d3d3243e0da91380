// What a renderer holds: everything on the GPU, and the layer under way. renderer.cpp has what may be asked of it.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gles/composite/camera_processing.hpp"
#include "gles/composite/composite.hpp"
#include "gles/composite/foreground.hpp"
#include "gles/composite/in_front.hpp"
#include "gles/composite/matte.hpp"
#include "gles/composite/processor_mix.hpp"
#include "gles/composite/renderer.hpp"
#include "gles/gl/picture_copy.hpp"
#include "gles/gpu_model/gpu_model.hpp"
#include "gles/light/radiance_atlas.hpp"
#include "gles/object/ground_light.hpp"
#include "gles/object/object_layer.hpp"
#include "gles/object/scene_depth.hpp"
#include "gles/picture/camera_input.hpp"
#include "gles/picture/response_table.hpp"

namespace kasumi {

struct Renderer::State {
  // A layer under way.
  struct UnfinishedLayer {
    ObjectAppearance appearance;
    std::shared_ptr<const AtlasSquares> sky;  // may be null
    ObjectDetail detail;
    PixelBox box;
    std::optional<SunShadowDrawing> shadow;  // while the shadow is drawn
    std::unique_ptr<GroundLight> ground;     // from the first tile on
    std::optional<LayerDrawing> drawing;     // afterwards
  };

  State(const GlInfo& gl_info, const RendererOptions& given) : info(gl_info), options(given) {}

  const GlInfo& info;
  RendererOptions options;
  Programs programs;
  GlTexture dither;
  CameraInput camera{info, options};
  std::optional<ResponseOnGpu> response;
  std::optional<GpuModel> model;
  RadianceAtlas sky;  // for the last light
  SurfaceUnits units_in_one_pass;
  std::optional<Projection> projection;
  ObjectDetail detail;
  PixelBox outline;  // of the object without any blur
  PixelBox box;      // of the object with its detail
  std::optional<Foreground> foreground;
  std::optional<Matte> matte;  // where the foreground leaves pixels of the object's box open
  int spare_unit = -1, passers_unit = -1;
  PassersOnGpu passers;
  std::optional<SceneDepth> scene_depth;
  int scene_depth_unit = -1;
  bool shadows_work = true;
  bool coarse_shadow = false;  // under the layer begun last
  bool many_varyings = true;   // more than GLES 2 guarantees
  SunShadow::Options shadow_options;
  std::optional<SunShadow> shadow;  // as drawn last
  std::optional<ModelUpload> unfinished_model;
  std::optional<UnfinishedLayer> unfinished_layer;
  std::optional<ObjectLayer> layer;
  Composite composite;
  std::shared_ptr<const JpegSteps> jpeg;  // of the newest picture
  std::optional<CameraProcessing> processing;
  std::optional<ProcessorMix> mix;  // empty: the GPU mixes
  PictureCopy copy;                 // of what it has mixed, to the target
  double bare = 0.0;                // of the target's width: without the layer
  std::vector<std::string> notes;

  bool layer_in_8_bits() const;
  void drop_layer();
  void look();
  PixelBox box_with(const ObjectDetail& blurred) const;

  // Of the pixels in which the foreground leaves the object open, if there are any.
  Result<> find_matte();
  Result<> follow_matte();

  FrameInputs frame() const;

  Result<> ready_for_frame(const DrawTarget& target) const;
  Result<> ready_for_layer(const AirlightGrid& measured, const DrawTarget& target, const SensorNoise& noise) const;

  ProcessingSteps wanted_processing() const;
  // The composite around the object as the camera would have processed it; null: it does nothing to its pictures.
  Result<const CameraProcessing*> process(const AirlightGrid& measured, const SensorNoise& noise);

  Result<> fits_view(int width, int height) const;
  Result<> ready_for_object() const;

  bool mixes() const { return mix && mix->has_picture(); }
  // The uploaded picture, with the layer in it where `measured` is given. Needs mixes().
  Result<const Image<glm::u8vec4>*> mixed(const AirlightGrid* measured, const SensorNoise& noise);
  Result<> show(const Image<glm::u8vec4>& picture, const DrawTarget& target);
  // For what the GPU draws itself.
  Result<> picture_on_gpu();

  bool casts_shadow(const ObjectAppearance& appearance) const;
  // Of the shadow to be drawn; empty: the one at hand is right.
  std::optional<SunFrame> new_shadow(const ObjectAppearance& appearance, bool coarse = false) const;
  // Redraws the shadow when the sun, the pose or its size in the picture has changed; null if the sun casts none.
  Result<const SunShadow*> shadow_under(const ObjectAppearance& appearance);

  void bind_for_layer() const;
  // The shadow is there.
  Result<> begin_tiles(UnfinishedLayer& unfinished);
  Result<> finish_layer(ObjectLayer drawn);
  Result<> take_layer(ObjectLayer made, const ObjectDetail& with);

  // Of the unfinished layer. true: it is whole.
  Result<bool> next_piece();

  // The filtered surroundings follow the light.
  Result<> follow(const ObjectLight& light, const AtlasSquares* prepared = nullptr);
  bool reflects() const { return std::ranges::any_of(model->materials(), &ModelMaterial::reflects); }
};

}  // namespace kasumi
