// What a camera does to its picture behind the sensor, done to the object, too: sharpening, and the blocks of its JPEG,
// rounded to the steps of the very stream. It works on the part of the composite around the object. Blocks in which
// nothing but the object is to be seen are kept, as long as it looks the same.
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
#include "gles/light/object_look.hpp"
#include "gles/picture/picture_mesh.hpp"
#include "gles/scene.hpp"

namespace kasumi {

struct ProcessingSteps {
  double sharpening = 0.0;                // amount a: encoded Y + a (Y - its binomial mean over 3 x 3 pixels); 0: none
  std::shared_ptr<const JpegSteps> jpeg;  // null: none
  glm::ivec2 shared_pixels{1, 1};         // for a colour difference of the JPEG
  bool none() const { return sharpening <= 0.0 && !jpeg; }
};

// Rectangles of a picture.
struct ObjectFootprint {
  std::vector<PixelBox> changed;  // hold the pixels that the object changes
  std::vector<PixelBox> covered;  // of those, the pixels in which nothing else is to be seen
  glm::ivec2 picture{};           // its size
  friend bool operator==(const ObjectFootprint&, const ObjectFootprint&) = default;
};

class CameraProcessing {
 public:
  // Something is changed. Errors: device.
  static Result<CameraProcessing> create(const ObjectFootprint& object, ProcessingSteps options, const GlInfo& info);
  bool is_for(const ObjectFootprint& object, const ProcessingSteps& options) const;
  // The object has changed in more than its look: its layer, the response.
  void forget();

  using Drawing = std::function<Result<>(const std::vector<PixelBox>* only)>;
  // The part of the picture around `changed` and the JPEG's blocks that it touches, which may reach beyond the picture.
  // Only these blocks are worked on.
  const PixelBox& part() const { return part_; }
  // `draw_camera`, `draw_composite`: draw that part, or `only` these of its pixels, given in the picture's, into the
  // bound framebuffer of its size, rows from the top; the composite with the object's share of each pixel in alpha, 0
  // only where it changes nothing. `look`: of the object in it; empty: something else may be seen anywhere before it.
  Result<> apply(const std::optional<ObjectLook>& look, Programs& programs, const Drawing& draw_camera,
                 const Drawing& draw_composite);
  // The result, for picture.frag with PROCESSED: where its alpha is not 0.
  void bind(const Program& program, bool smooth) const;

 private:
  CameraProcessing() = default;
  glm::ivec2 size() const { return {part_.right - part_.left, part_.bottom - part_.top}; }
  glm::ivec2 luma_size() const { return {size().x / 2, size().y}; }  // texels
  glm::dvec2 last_place() const;
  struct Done {
    LayerBuffer picture;
    std::optional<ObjectLook> look;  // of the blocks kept in it; empty: none
  };
  Result<> sharpen(Programs& programs, const LayerBuffer& sharpened) const;
  Result<> round_blocks(Programs& programs, const LayerBuffer& picture, const LayerBuffer& rounded) const;
  void draw_into(const LayerBuffer& buffer, glm::ivec2 buffer_size, const Program& program) const;
  enum class Along { rows, columns };
  // One of jpeg.frag's, into a buffer of luma or of chroma.
  Result<> pass(Programs& programs, const Defines& defines, const LayerBuffer& from, glm::ivec2 from_size, Along along,
                bool chroma, const LayerBuffer& to) const;

  const GlInfo* info_ = nullptr;
  ProcessingSteps options_;
  ObjectFootprint object_;
  PixelBox part_;
  std::optional<PictureMesh> blocks_, live_blocks_;  // from the part's corner: all, and those that are not kept
  std::vector<PixelBox> live_pixels_;                // that they are made from, in the picture
  bool only_live_ = false;                           // are worked on with this picture
  std::array<Done, kNoisePatterns> done_;            // of each pattern of noise
  std::size_t newest_ = 0;
  LayerBuffer composite_, camera_, sharpened_;  // pictures on the way
  std::array<LayerBuffer, 2> luma_, chroma_;    // two values a texel, in turn
  GlTexture steps_;
};

}  // namespace kasumi
