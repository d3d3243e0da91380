// Textures of the model on the GPU, with mipmaps averaged in linear light.
#pragma once

#include <optional>
#include <vector>

#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

// Half the size each way (rounded down, at least 1): the mean of the texels under each new one. Colours are averaged in
// linear light and weighted by alpha; data directly.
Image<glm::u8vec4> halved(const Image<glm::u8vec4>& picture, bool data = false);

// The share of a picture whose alpha, interpolated bilinearly, is at least `cutoff`.
double share_above(const Image<glm::u8vec4>& picture, double cutoff, double alpha_scale = 1.0);

// The lowest alpha cutoff of the masked materials that use this texture; empty: no such material.
std::optional<double> cutoff_of(const Model& model, int texture);

struct SurfaceTexture {
  GlTexture texture;
  bool decodes = false;   // sampling returns linear light; otherwise the shader decodes
  bool data = false;      // nothing to decode
  std::size_t bytes = 0;  // on the GPU, with all levels
};

// Pictures beyond the driver's limit are halved until they fit; drivers without arbitrary texture sizes get powers of
// two. Both are reported in notes. `cutoff`: see cutoff_of; the smaller levels then keep the picture's coverage
// (Castano 2010), or a fence would vanish with distance.
Result<SurfaceTexture> upload(const ModelTexture& texture, std::optional<double> cutoff, const GlInfo& info,
                              bool force_encoded, std::vector<std::string>& notes);

}  // namespace kasumi
