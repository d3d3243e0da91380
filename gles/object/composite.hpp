// The camera's picture on a target, with the object's layer in it.
#pragma once

#include <optional>

#include <glm/mat3x3.hpp>

#include "gles/gl/target.hpp"
#include "gles/object/object_layer.hpp"
#include "gles/picture/camera_textures.hpp"
#include "gles/picture/picture_mesh.hpp"
#include "gles/picture/response_table.hpp"

namespace kasumi {

// Where a target shows the picture, and how pixels get there.
struct PictureOnTarget {
  Letterbox box;
  bool same_size = true;
  glm::dmat3 pixel_to_clip{1.0};
  glm::dmat3 fragment_to_picture{1.0};

  PictureOnTarget(const DrawTarget& target, int width, int height);
  // Binds the target and blackens what the picture leaves of it.
  void begin(const DrawTarget& target, bool with_depth) const;
};

// What every program that shows the camera's picture needs.
struct CameraFrame {
  const CameraTextures& camera;
  const ResponseOnGpu& response;
  const GlTexture& dither;
  void bind(const Program& program, const PictureOnTarget& shown) const;
};

// How the picture is cut, and the noise: what stays from frame to frame.
class Composite {
 public:
  // The layer's coverage, 0..1; cuts the picture anew.
  void take(const ObjectLayer& layer, const SceneView& view, const Image<glm::vec4>& texels);
  void drop_layer() { mesh_.reset(); }

  Result<> draw_camera_alone(Programs& programs, const CameraFrame& frame, const PictureOnTarget& shown);
  Result<> draw(Programs& programs, const CameraFrame& frame, const PictureOnTarget& shown, const ObjectLayer& layer,
                const AirlightGrid& measured, const SensorNoise& noise);

 private:
  const PictureMesh& mesh_for(const AirlightGrid& grid);
  void bind_noise(const Program& program, const SensorNoise& noise, bool smooth);

  PictureRectangles rectangles_;      // of the camera's picture around and under the layer
  std::optional<PictureMesh> mesh_;   // of these, cut at the lines of a grid of airlight
  AirlightGrid mesh_grid_;            // that grid
  std::optional<PictureMesh> whole_;  // the same without a layer
  glm::ivec2 whole_size_{};
  GlTexture noise_;  // made for the first frame that wants it
};

}  // namespace kasumi
