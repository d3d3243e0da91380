// Draws the camera's picture with the object's layer over it.
#pragma once

#include <optional>

#include <glm/mat3x3.hpp>

#include "gles/gl/target.hpp"
#include "gles/object/camera_processing.hpp"
#include "gles/object/foreground.hpp"
#include "gles/object/in_front.hpp"
#include "gles/object/matte.hpp"
#include "gles/object/object_layer.hpp"
#include "gles/picture/camera_textures.hpp"
#include "gles/picture/picture_mesh.hpp"
#include "gles/picture/response_table.hpp"

namespace kasumi {

// Where a target shows the picture, and the transform to its pixels.
struct PictureOnTarget {
  Letterbox box;
  bool same_size = true;
  glm::dmat3 pixel_to_clip{1.0};
  glm::dmat3 fragment_to_picture{1.0};

  PictureOnTarget(const DrawTarget& target, int width, int height);
  // Of a part of the picture only, pixel by pixel, top row first.
  PictureOnTarget(const PixelBox& part, int width, int height);
  // Binds the target and fills the area outside the picture with black.
  void begin(const DrawTarget& target, bool with_depth) const;
};

// The inputs of every program that shows the camera's picture.
struct CameraFrame {
  const CameraTextures& camera;
  const ResponseOnGpu& response;
  const GlTexture& dither;
  const Foreground* foreground = nullptr;  // null: it leaves no pixel of the object open
  const Matte* matte = nullptr;            // null: such pixels are mixed as the mask says
  const PassersOnGpu* passers = nullptr;   // null: nobody passes before the object
  int passers_unit = -1;                   // where the foreground leaves pixels open; < 0: the driver has none
  int spare_unit = -1;                     // beyond those that GLES 2 promises; < 0: the driver has none
  void bind(const Program& program, const PictureOnTarget& shown) const;
};

// The picture's cutting and the noise, which stay the same between frames.
class Composite {
 public:
  // The layer's coverage, 0..1; cuts the picture again. Pixels that the foreground leaves open are edges.
  void take(const ObjectLayer& layer, const SceneView& view, const Image<glm::vec4>& texels,
            const Foreground* foreground);
  void drop_layer() {
    mesh_.reset();
    covered_ = {};
    is_left_open_ = false;
  }
  PixelBox covered() const { return covered_; }        // the pixels that the layer changes lie in it
  std::vector<PixelBox> changed() const;               // and in these rectangles
  bool is_left_open() const { return is_left_open_; }  // in some of them, by the foreground

  Result<> draw_camera_alone(Programs& programs, const CameraFrame& frame, const PictureOnTarget& shown);
  // `processing`, already applied, stands for layer, airlight and noise; null: none.
  Result<> draw(Programs& programs, const CameraFrame& frame, const PictureOnTarget& shown, const ObjectLayer& layer,
                const AirlightGrid& measured, const SensorNoise& noise, const CameraProcessing* processing = nullptr);
  // The same with the object's share of each pixel in alpha.
  Result<> draw_with_coverage(Programs& programs, const CameraFrame& frame, const PictureOnTarget& shown,
                              const ObjectLayer& layer, const AirlightGrid& measured, const SensorNoise& noise);
  // Only the layer, as the display lays it over the camera's picture of `frame`.
  Result<> draw_for_plane(Programs& programs, const CameraFrame& frame, const PictureOnTarget& shown,
                          const ObjectLayer& layer, const AirlightGrid& measured, const SensorNoise& noise,
                          const CameraProcessing* processing = nullptr);

 private:
  Result<> draw_area(PictureArea area, Defines defines, Programs& programs, const CameraFrame& frame,
                     const PictureOnTarget& shown, const ObjectLayer& layer, const AirlightGrid& measured,
                     const SensorNoise& noise, const CameraProcessing* processing);
  const PictureMesh& mesh_for(const AirlightGrid& grid);
  void bind_noise(const Program& program, const SensorNoise& noise, bool smooth);

  PixelBox covered_;
  bool is_left_open_ = false;
  PictureRectangles rectangles_;      // of the camera's picture around and under the layer
  std::optional<PictureMesh> mesh_;   // of these rectangles, cut at the lines of a grid of airlight
  AirlightGrid mesh_grid_;            // that grid
  std::optional<PictureMesh> whole_;  // the same without a layer
  glm::ivec2 whole_size_{};
  GlTexture noise_;  // created with the first frame that needs it
};

}  // namespace kasumi
