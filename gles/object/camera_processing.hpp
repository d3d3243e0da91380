// What a camera does to its picture behind the sensor, done to the object, too: sharpening, and the blocks of its JPEG,
// rounded to the steps of the very stream. It works on the part of the composite around the object.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>

#include "base/image.hpp"
#include "base/jpeg_steps.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/layer_buffer.hpp"
#include "gles/gpu_model/programs.hpp"
#include "gles/picture/picture_mesh.hpp"
#include "gles/scene.hpp"

namespace kasumi {

struct ProcessingOptions {
  double sharpening = 0.0;                // amount a: encoded Y + a (Y - its binomial mean over 3 x 3 pixels); 0: none
  std::shared_ptr<const JpegSteps> jpeg;  // null: none
  glm::ivec2 shared_pixels{1, 1};         // for a colour difference of the JPEG
  bool none() const { return sharpening <= 0.0 && !jpeg; }
};

class CameraProcessing {
 public:
  // `changed`: rectangles that hold the pixels that the object changes, in a picture of that size; not empty. Errors:
  // device.
  static Result<CameraProcessing> create(const std::vector<PixelBox>& changed, glm::ivec2 picture,
                                         ProcessingOptions options, const GlInfo& info);
  bool is_for(const std::vector<PixelBox>& changed, glm::ivec2 picture, const ProcessingOptions& options) const;

  // The part of the picture around `changed` and the JPEG's blocks that it touches, which may reach beyond the picture.
  // Only these blocks are worked on.
  const PixelBox& part() const { return part_; }
  // `draw_camera`, `draw_composite`: draw that part into the bound framebuffer of its size, rows from the top; the
  // composite with the object's share of each pixel in alpha.
  Result<> apply(Programs& programs, const std::function<Result<>()>& draw_camera,
                 const std::function<Result<>()>& draw_composite);
  // The result, for picture.frag with PROCESSED.
  void bind(const Program& program, bool smooth) const;

 private:
  CameraProcessing() = default;
  glm::ivec2 size() const { return {part_.right - part_.left, part_.bottom - part_.top}; }
  glm::ivec2 luma_size() const { return {size().x / 2, size().y}; }  // texels
  glm::dvec2 last_place() const;
  Result<> sharpen(Programs& programs);
  Result<> round_blocks(Programs& programs);
  void draw_into(const LayerBuffer& buffer, glm::ivec2 buffer_size, const Program& program) const;
  enum class Along { rows, columns };
  // One of jpeg.frag's, into a buffer of luma or of chroma.
  Result<> pass(Programs& programs, const Defines& defines, const LayerBuffer& from, glm::ivec2 from_size, Along along,
                bool chroma, const LayerBuffer& to) const;

  ProcessingOptions options_;
  std::vector<PixelBox> changed_;
  PixelBox part_;
  std::optional<PictureMesh> blocks_;  // from the part's corner
  glm::ivec2 picture_{};
  LayerBuffer result_;                        // the picture
  LayerBuffer camera_, sharpened_;            // pictures, while it is sharpened
  std::array<LayerBuffer, 2> luma_, chroma_;  // two values a texel, in turn
  GlTexture steps_;
};

}  // namespace kasumi
