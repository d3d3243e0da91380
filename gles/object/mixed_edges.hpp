// Pixels that the object covers in part, mixed by the processor with the text of picture.frag.
#pragma once

#include <array>
#include <vector>

#include <glm/gtc/type_precision.hpp>
#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "gles/object/matte_nodes.hpp"
#include "gles/scene.hpp"

namespace kasumi {

// A camera's response in the entries of response_texels(): light of code, code of the square root of light.
struct ResponseTables {
  explicit ResponseTables(const ResponseCurve& response);
  std::array<std::array<std::vector<float>, 3>, 2> values;
};

// The patterns of gles/gl/patterns.hpp.
struct MixPatterns {
  Image<std::uint8_t> dither;
  const Image<glm::u8vec3>* noise;
};

// The object's layer as its texture holds it (layer.glsl).
struct LayerTexels {
  PixelBox box;
  double unit = 1.0;
  Image<glm::vec4> texels;
};

// All but the picture and the table stay between pictures.
struct EdgeInputs {
  const PictureView& camera;
  const ResponseTables& response;
  const MixPatterns& patterns;
  const LayerTexels& layer;
  const Image<glm::u8vec2>* foreground;  // free share, confidence; null: none
  const MatteNodes* matte;               // null: mixed as the mask says
  const InFront* passers;                // null: none
  const AirlightGrid& measured;
  const SensorNoise& noise;
};

// Of these rectangles, into an image whose first pixel is the picture's at `first`: where the object changes a pixel,
// with its share in alpha, at least 1.
void mix_edges(const EdgeInputs& inputs, const std::vector<PixelBox>& rectangles, glm::ivec2 first,
               Image<glm::u8vec4>& mixed);

}  // namespace kasumi
