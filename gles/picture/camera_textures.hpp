// How shaders read the camera's picture: its textures and the contents of their channels.
#pragma once

#include <array>

#include "base/picture.hpp"
#include "gles/gl/program.hpp"

namespace kasumi {

struct CameraTextures {
  enum class Source {
    uploaded,  // planes copied into textures: luminance, luminance and alpha, RGB(A)
    imported,  // planes in a driver's memory: red, red and green, RGBA
    external,  // the whole picture in a driver's memory, converted to RGB by the GPU's driver
  };
  Source source = Source::uploaded;
  PixelLayout layout = PixelLayout::rgb8;
  YuvEncoding encoding = YuvEncoding::bt601_full;
  int width = 0;
  int height = 0;
  std::array<unsigned, 3> names{};

  bool empty() const { return width == 0; }
  int count() const;
  // Whether its shader finds each pixel's own byte by computing with the pixel's column: beyond 16 bits.
  static bool needs_high_precision(PixelLayout layout) {
    return layout == PixelLayout::yuyv || layout == PixelLayout::uyvy;
  }
  // The defines for camera_picture.glsl.
  Defines defines() const;
  // Binds to texture units 0 .. 2 and sets the uniforms of camera_picture.glsl. smooth: filtered, for scaling.
  void bind(const Program& program, bool smooth) const;
};

}  // namespace kasumi
