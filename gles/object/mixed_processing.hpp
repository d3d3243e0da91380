// What CameraProcessing does to the composite around the object, done by the processor: sharpening as sharpen.frag, the
// blocks of the camera's JPEG as jpeg.frag, with values rounded between the passes as their textures round them.
#pragma once

#include <vector>

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"
#include "gles/object/camera_processing.hpp"

namespace kasumi {

class MixedProcessing {
 public:
  MixedProcessing(const ObjectInPicture& object, ProcessingOptions options);
  bool is_for(const ObjectInPicture& object, const ProcessingOptions& options) const;
  // Whole blocks around what changes, which may reach beyond the picture.
  const PixelBox& part() const { return part_; }

  // `camera`: the picture. `composite`: of part(), the object's share in alpha, 0 where it changes nothing; becomes the
  // result, with the same alpha.
  void apply(const Image<glm::u8vec4>& camera, Image<glm::u8vec4>& composite);

 private:
  void sharpen(const Image<glm::u8vec4>& camera, Image<glm::u8vec4>& composite);
  void round_block(int left, int top, const Image<glm::u8vec4>& from, Image<glm::u8vec4>& to) const;

  ObjectInPicture object_;
  ProcessingOptions options_;
  PixelBox part_;
  std::vector<PixelBox> blocks_;     // in pixels from the part's corner
  Image<float> luma_, camera_luma_;  // of the part, encoded
  Image<glm::u8vec4> sharpened_;
};

}  // namespace kasumi
