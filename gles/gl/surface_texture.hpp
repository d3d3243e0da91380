// Textures of the model on the GPU, with mipmaps averaged in linear light.
#pragma once

#include <optional>
#include <vector>

#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"
#include "gles/model/model.hpp"

namespace kasumi {

// Half the size each way (rounded down, at least 1): the mean of the texels under each new one, colours in linear light
// and weighted by alpha; data as it is.
Image<glm::u8vec4> halved(const Image<glm::u8vec4>& picture, bool data = false);

// The share of a picture that shows where what has less alpha than `cutoff` is left out, bilinear between the texels.
double share_above(const Image<glm::u8vec4>& picture, double cutoff, double alpha_scale = 1.0);

// The lowest alpha that is left standing on this texture by the masked materials that use it; empty: nothing is cut
// out.
std::optional<double> cutoff_of(const Model& model, int texture);

struct SurfaceTexture {
  GlTexture texture;
  bool decodes = false;   // sampling yields linear light; otherwise the shader decodes
  bool data = false;      // nothing to decode
  std::size_t bytes = 0;  // on the GPU, with all levels
};

// Pictures beyond the driver's limit are halved until they fit; drivers without free texture sizes get powers of two.
// Both are told in notes. `cutoff`: see cutoff_of; the smaller levels then show as much as the picture itself (Castano
// 2010), or a fence would vanish with distance.
Result<SurfaceTexture> upload(const ModelTexture& texture, std::optional<double> cutoff, const GlInfo& info,
                              bool force_encoded, std::vector<std::string>& notes);

}  // namespace kasumi
