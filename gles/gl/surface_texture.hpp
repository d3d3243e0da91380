// Textures of the model on the GPU.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"
#include "gles/model/mip_levels.hpp"

namespace kasumi {

struct SurfaceTexture {
  GlTexture texture;
  bool decodes = false;   // sampling returns linear light; otherwise the shader decodes
  bool data = false;      // nothing to decode
  std::size_t bytes = 0;  // on the GPU, with all levels
};

// Puts a texture with its smaller levels on the GPU, a few megabytes at a time. Pictures beyond the driver's limit, or
// beyond 2048 texels a side where the processor draws, are halved until they fit; drivers without arbitrary texture
// sizes get powers of two. Both are reported in notes.
class SurfaceTextureUpload {
 public:
  // `texture` must outlive it. `cutoff`: see cutoff_of(); used where the texture brings no smaller levels.
  SurfaceTextureUpload(const ModelTexture& texture, std::optional<double> cutoff, const GlInfo& info,
                       bool force_encoded, std::vector<std::string>& notes);
  // true: it is whole. BLOCKS for seconds, once, where smaller levels must be made. Errors: device.
  Result<bool> step();
  SurfaceTexture take() { return std::move(made_); }

 private:
  const Image<glm::u8vec4>& level() const { return *levels_[level_]; }
  void gather_levels(std::optional<double> cutoff, const GlInfo& info);
  void set_filters() const;

  const ModelTexture& texture_;
  std::vector<Image<glm::u8vec4>> own_;            // levels that the model does not have
  std::vector<const Image<glm::u8vec4>*> levels_;  // the largest first
  bool anisotropic_;
  unsigned format_;
  std::size_t level_ = 0;  // the next to be uploaded, from this row on
  int row_ = 0;
  SurfaceTexture made_;
};

}  // namespace kasumi
