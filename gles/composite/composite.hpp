// Draws the camera's picture with the object's layer over it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "gles/composite/camera_processing.hpp"
#include "gles/composite/finished_pixels.hpp"
#include "gles/composite/foreground.hpp"
#include "gles/composite/in_front.hpp"
#include "gles/composite/matte.hpp"
#include "gles/object/object_layer.hpp"
#include "gles/picture/camera_textures.hpp"
#include "gles/picture/picture_mesh.hpp"
#include "gles/picture/response_table.hpp"
#include "gles/picture/target_placement.hpp"

namespace kasumi {

// The inputs of every program that shows the camera's picture.
struct FrameInputs {
  const CameraTextures& camera;
  const ResponseOnGpu& response;
  const GlTexture& dither;
  const Foreground* foreground = nullptr;  // null: it leaves no pixel of the object open
  const Matte* matte = nullptr;            // null: such pixels are mixed as the mask says
  const PassersOnGpu* passers = nullptr;   // null: no passers before the object
  int passers_unit = -1;                   // where the foreground leaves pixels open; < 0: the driver has none
  int spare_unit = -1;                     // beyond those that GLES 2 promises; < 0: the driver has none
  void bind(const Program& program, const TargetPlacement& shown) const;
};

// The object's covered pixels in memory.
struct CoveredPixels {
  const Image<glm::u8vec4>* pixels = nullptr;  // of Composite::covered(); null: none
  std::uint64_t drawing = 0;                   // > 0; another one: they may have changed
};

// The picture's cutting and the noise, which stay the same between frames.
class Composite {
 public:
  // The layer's coverage, 0..1; cuts the picture again. Pixels that the foreground leaves open are edges.
  void take(const ObjectLayer& layer, const SceneView& view, const Image<glm::vec4>& texels,
            const Foreground* foreground);
  void drop_layer() {
    mesh_ = {};
    part_ = {};
    covered_ = {};
    fully_covered_.clear();
    is_left_open_ = false;
    finished_.clear();
    for_processor_.clear();
  }
  void change_response() {
    finished_.clear();
    for_processor_.clear();
  }
  PixelBox covered() const { return covered_; }  // the pixels that the layer changes lie in it
  std::vector<PixelBox> changed() const;         // and in these rectangles
  // The pixels in which nothing else is to be seen, a rectangle for each run of a row.
  const std::vector<PixelBox>& fully_covered() const { return fully_covered_; }
  bool is_left_open() const { return is_left_open_; }  // in some of them, by the foreground

  Result<> draw_camera_alone(Programs& programs, const FrameInputs& frame, const TargetPlacement& shown);
  // Before draw() with the same values and without processing: what need not be drawn again with every picture. Binds
  // another framebuffer.
  Result<> finish(Programs& programs, const FrameInputs& frame, const TargetPlacement& shown, const ObjectLayer& layer,
                  const AirlightGrid& measured, const SensorNoise& noise, const GlInfo& info);
  // What draw() shows in fully_covered(), for the processor to mix. It is drawn only when its look changes. Errors:
  // device.
  Result<CoveredPixels> covered_pixels(Programs& programs, const FrameInputs& frame, const ObjectLayer& layer,
                                       const AirlightGrid& measured, const SensorNoise& noise, const GlInfo& info);
  const std::vector<PixelBox>& rectangles(CutArea area) const { return rectangles_[static_cast<std::size_t>(area)]; }
  // `processing`, already applied, stands for layer, airlight and noise; null: none.
  Result<> draw(Programs& programs, const FrameInputs& frame, const TargetPlacement& shown, const ObjectLayer& layer,
                const AirlightGrid& measured, const SensorNoise& noise, const CameraProcessing* processing = nullptr);
  // In these rectangles alone.
  Result<> draw_camera_in(const std::vector<PixelBox>& parts, Programs& programs, const FrameInputs& frame,
                          const TargetPlacement& shown);
  // draw() with the object's share of each pixel in alpha; `only` in these rectangles, or, null, everywhere.
  Result<> draw_with_coverage(const std::vector<PixelBox>* only, Programs& programs, const FrameInputs& frame,
                              const TargetPlacement& shown, const ObjectLayer& layer, const AirlightGrid& measured,
                              const SensorNoise& noise);
  // Only the layer, as the display lays it over the camera's picture of `frame`.
  Result<> draw_for_plane(Programs& programs, const FrameInputs& frame, const TargetPlacement& shown,
                          const ObjectLayer& layer, const AirlightGrid& measured, const SensorNoise& noise,
                          const CameraProcessing* processing = nullptr);

 private:
  // Rectangles on the GPU, cut at the lines of a grid of airlight.
  struct CutMesh {
    std::optional<PictureMesh> mesh;
    AirlightGrid grid;
    const PictureMesh& at(const AirlightGrid& wanted, const CutRectangles& rectangles);
  };
  // A part of the rectangles.
  struct Part {
    std::vector<PixelBox> boxes;
    std::optional<PictureMesh> camera;  // of the boxes
    CutRectangles rectangles;           // what lies in them
    CutMesh mesh;
  };
  Part& part_in(const std::vector<PixelBox>& boxes);
  const PictureMesh& mesh_for(const AirlightGrid& grid, Part* part);
  Result<> draw_camera_on(const PictureMesh& mesh, Programs& programs, const FrameInputs& frame,
                          const TargetPlacement& shown);
  // `part`: this alone; null: everywhere.
  Result<> draw_area(CutArea area, Part* part, Defines defines, Programs& programs, const FrameInputs& frame,
                     const TargetPlacement& shown, const ObjectLayer& layer, const AirlightGrid& measured,
                     const SensorNoise& noise, const CameraProcessing* processing);
  Result<> draw_finished(Programs& programs, const FrameInputs& frame, const TargetPlacement& shown);
  void bind_noise(const Program& program, const SensorNoise& noise, bool smooth);

  PixelBox covered_;
  std::vector<PixelBox> fully_covered_;
  bool is_left_open_ = false;
  CutRectangles rectangles_;          // of the camera's picture around and under the layer
  CutMesh mesh_;                      // of these
  Part part_;                         // drawn last; without boxes: none
  std::optional<PictureMesh> whole_;  // the same without a layer
  glm::ivec2 whole_size_{};
  FinishedPixels finished_, for_processor_;                 // the latter with the edges' covered pixels
  bool is_finished_ = false;                                // for the picture to be drawn
  Image<glm::u8vec4> not_kept_;                             // covered_pixels() of a look that has just changed
  std::array<std::uint64_t, kNoisePatterns> drawing_of_{};  // of covered pixels that were kept
  std::uint64_t drawings_ = 0;
  GlTexture noise_;  // created with the first frame that needs it
};

}  // namespace kasumi
