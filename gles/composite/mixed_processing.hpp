// What CameraProcessing does to the composite around the object, done by the processor: sharpening as sharpen.frag, the
// blocks of the camera's JPEG as jpeg.frag, with values rounded between the passes as their textures round them. Blocks
// in which nothing but the object is to be seen are kept.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"
#include "gles/composite/camera_processing.hpp"
#include "gles/scene.hpp"

namespace kasumi {

class MixedProcessing {
 public:
  MixedProcessing(const ObjectFootprint& object, ProcessingSteps options);
  bool is_for(const ObjectFootprint& object, const ProcessingSteps& options) const;
  // Whole blocks around what changes, which may reach beyond the picture.
  const PixelBox& part() const { return part_; }

  // Rectangles of the picture, and of the object's covered pixels.
  struct Wanted {
    std::vector<PixelBox> pixels, covered;
  };
  // What the next apply() reads of the composite. Blocks are kept by the noise's `pattern`, as long as `drawing`, which
  // numbers what the covered pixels are (CoveredPixels), stays the same; 0: something may be in front of them.
  const Wanted& begin(std::size_t pattern, std::uint64_t drawing);
  // `composite`: of part(), the object's share in alpha, 0 where it changes nothing. The result goes into `picture`,
  // the camera's.
  void apply(Image<glm::u8vec4>& picture, Image<glm::u8vec4>& composite);

 private:
  struct Blocks : Wanted {
    std::vector<PixelBox> blocks;  // in pixels from the part's corner
  };
  struct Kept {
    std::uint64_t drawing = 0;
    Image<glm::u8vec4> pixels;  // of the part
  };
  Blocks all_or_live(const std::vector<PixelBox>& blocks) const;
  void sharpen(const Image<glm::u8vec4>& camera, Image<glm::u8vec4>& composite);
  void sharpen_row(int y, int left, int right, Image<glm::u8vec4>& composite) const;
  void round_block(int left, int top, Image<glm::u8vec4>& composite) const;
  glm::ivec2 last() const;  // of the part's pixels in the picture

  ObjectFootprint object_;
  ProcessingSteps options_;
  PixelBox part_;
  Blocks all_, live_;
  std::vector<PixelBox> kept_blocks_;  // all but the live ones, as those
  std::array<Kept, kNoisePatterns> kept_;
  std::size_t pattern_ = 0;
  std::uint64_t drawing_ = 0;
  bool only_live_ = false;
  Image<float> luma_, camera_luma_;  // of the part, encoded, with a column before and one behind that repeat its ends
};

}  // namespace kasumi
