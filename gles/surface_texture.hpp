// Textures of the model on the GPU, with mipmaps averaged in linear light.
#pragma once

#include <vector>

#include "base/result.hpp"
#include "gles/context.hpp"
#include "gles/model.hpp"
#include "gles/objects.hpp"

namespace kasumi {

// Half the size each way (rounded down, at least 1): the mean of the texels under each new one, colours in linear light
// and weighted by alpha.
Image<glm::u8vec4> halved(const Image<glm::u8vec4>& picture);

struct SurfaceTexture {
  GlTexture texture;
  bool decodes = false;  // sampling yields linear light; otherwise the shader decodes
};

// Pictures beyond the driver's limit are halved until they fit; drivers without free texture sizes get powers of two.
// Both are told in notes.
Result<SurfaceTexture> upload(const ModelTexture& texture, const GlInfo& info, bool force_encoded,
                              std::vector<std::string>& notes);

}  // namespace kasumi
