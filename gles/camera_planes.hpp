// The camera's picture on the GPU, in the planes its driver delivers.
#pragma once

#include <array>
#include <vector>

#include "base/picture.hpp"
#include "base/result.hpp"
#include "gles/context.hpp"
#include "gles/objects.hpp"
#include "gles/program.hpp"

namespace kasumi {

class CameraPlanes {
 public:
  // Errors: bad_input (no pixels, missing planes, strides shorter than rows, larger than GL_MAX_TEXTURE_SIZE), device.
  Result<> upload(const PictureView& picture, const GlInfo& info);

  bool empty() const { return width_ == 0; }
  int width() const { return width_; }
  int height() const { return height_; }
  // Which variant of camera_picture.glsl reads these planes.
  std::string define() const;
  // To texture units 0 .. 2, and the uniforms of camera_picture.glsl. smooth: filtered, for showing at another size.
  void bind(const Program& program, bool smooth) const;

 private:
  struct Texels {  // how a plane goes into a texture
    unsigned format = 0;
    std::size_t bytes = 1;  // per texel
    int width = 0;
    int height = 0;
    friend bool operator==(const Texels&, const Texels&) = default;
  };
  static Texels texels_of(const PictureView& picture, int plane);
  void upload_plane(const PictureView& picture, int plane, const GlInfo& info);

  PixelLayout layout_ = PixelLayout::rgb8;
  YuvEncoding encoding_ = YuvEncoding::bt601_full;
  int width_ = 0;
  int height_ = 0;
  std::array<GlTexture, 3> textures_;
  std::array<Texels, 3> held_;
  std::vector<std::uint8_t> packed_;  // rows without gaps, for drivers that cannot skip them
};

}  // namespace kasumi
