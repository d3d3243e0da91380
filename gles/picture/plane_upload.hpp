// Copies the camera's picture to the GPU, in the planes its driver delivers.
#pragma once

#include <array>
#include <vector>

#include "base/picture.hpp"
#include "base/result.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/objects.hpp"
#include "gles/picture/camera_textures.hpp"

namespace kasumi {

class PlaneUpload {
 public:
  // Errors: bad_input (no pixels, missing planes, strides shorter than rows, larger than GL_MAX_TEXTURE_SIZE), device.
  Result<CameraTextures> upload(const PictureView& picture, const GlInfo& info);

 private:
  struct Texels {  // a plane's texture format
    unsigned format = 0;
    std::size_t bytes = 1;  // per texel
    int width = 0;
    int height = 0;
    friend bool operator==(const Texels&, const Texels&) = default;
  };
  static Texels texels_of(const PictureView& picture, int plane);
  void upload_plane(const PictureView& picture, int plane, const GlInfo& info);

  std::array<GlTexture, 3> textures_;
  std::array<Texels, 3> held_;
  PictureView apart(const PictureView& picture);

  std::vector<std::uint8_t> apart_;   // planes of a picture that the shader cannot take apart
  std::vector<std::uint8_t> packed_;  // rows without gaps, for drivers that cannot skip them
};

}  // namespace kasumi
