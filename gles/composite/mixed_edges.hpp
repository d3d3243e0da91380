// Pixels that the object covers in part, mixed by the processor with the text of picture.frag.
#pragma once

#include <array>
#include <vector>

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "gles/composite/mixed_pixels.hpp"
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

struct EdgeInputs {
  const PictureView& camera;
  const ResponseTables& response;
  const MixPatterns& patterns;
  const MixedPixels& pixels;
  const InFront* passers;  // null: none; else all of the object is mixed
  const AirlightGrid& measured;
  const SensorNoise& noise;
};

// Memory that is used again for the next picture.
struct MatteLight {
  std::vector<float> light;  // red, green and blue of the band's plane, and eight before and after them
  std::vector<float> nodes;  // four channels of what is behind, four of what is in front; as their texture holds them
  std::vector<float> lines;  // the same in a row of pixels
};

// Into an image whose first pixel is the picture's at `first`: where the object changes a pixel, with its share in
// alpha, at least 1.
void mix_edges(const EdgeInputs& inputs, glm::ivec2 first, Image<glm::u8vec4>& mixed, MatteLight& kept);

}  // namespace kasumi
