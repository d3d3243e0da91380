// The camera's picture and the object's layer mixed by the processor, for machines whose GL is software: only the box of
// the object is mixed, all else is the camera's picture, converted.
#pragma once

#include <optional>
#include <vector>

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "base/result.hpp"
#include "gles/composite/composite.hpp"
#include "gles/composite/mixed_edges.hpp"
#include "gles/composite/mixed_processing.hpp"
#include "gles/picture/camera_pixels.hpp"
#include "gles/picture/plane_upload.hpp"

namespace kasumi {

class ProcessorMix {
 public:
  ProcessorMix();

  // What stays between pictures.
  void take_response(const ResponseCurve& response) { response_ = ResponseTables(response); }
  void take_matte(MatteNodes nodes) { nodes_ = std::move(nodes); }
  // `foreground`: as MixedPixels has it; `matte`: the one taken counts.
  void take_layer(const LayerTexels& layer, const Composite& composite, const Image<glm::u8vec2>* foreground,
                  bool matte);
  // Each picture's own. Errors: bad_input (no pixels, planes too small).
  Result<> take_picture(const PictureView& picture) { return planes_.take(picture); }
  void drop_picture() { planes_.clear(); }
  void take_passers(const InFront& passers) { passers_ = passers; }

  bool has_picture() const { return !planes_.empty(); }
  const PictureView& planes() const { return planes_.view(); }

  // The picture alone, and the picture with the layer in it. Both stay until the next call; their alpha means nothing.
  const Image<glm::u8vec4>& background();
  struct Parts {
    const Composite& composite;
    const CoveredPixels& covered;
    bool passers;  // those taken count
    ProcessingSteps processing;
    const AirlightGrid& measured;
    const SensorNoise& noise;
  };
  const Image<glm::u8vec4>& mix(const Parts& parts);

  // As a texture that is shown like a camera's picture. Errors: device, bad_input (larger than the driver's textures).
  Result<CameraTextures> upload(const Image<glm::u8vec4>& picture, const GlInfo& info);

 private:
  void mix_processed(const Parts& parts, const EdgeInputs& inputs);

  KeptPlanes planes_;
  Image<glm::u8vec4> picture_, composite_;
  ResponseTables response_;
  MixPatterns patterns_;
  MatteNodes nodes_;
  MixedPixels pixels_;
  MatteLight matte_light_;
  InFront passers_;
  std::optional<MixedProcessing> processing_;
  PlaneUpload shown_;
};

}  // namespace kasumi
