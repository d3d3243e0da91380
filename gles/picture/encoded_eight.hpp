// Eight neighbours of the camera's picture as a shader computes them (camera_picture.glsl): encoded, not rounded,
// perhaps beyond 0..1.
#pragma once

#include <algorithm>
#include <array>

#include "base/picture.hpp"
#include "gles/picture/camera_pixels.hpp"
#include "gles/picture/wide_vectors.hpp"

namespace kasumi {

// Of the planes of one picture.
class EncodedEight {
 public:
  explicit EncodedEight(const PictureView& planes)
      : picture_(&planes), matrix_(yuv_to_rgb(planes.encoding)), rgb_(rgb_bytes(planes.layout)) {}

  // Red, green and blue from pixel `x`, which is even, of row `y` on. Beyond the picture its edge is repeated.
  std::array<Floats, 3> at(int x, int y) const {
    const PictureView& p = *picture_;
    const int row = std::clamp(y, 0, p.height - 1);
    if (rgb_.step == 4)
      return {values<4>(0, row, x, rgb_.red), values<4>(0, row, x, 1), values<4>(0, row, x, rgb_.blue)};
    if (rgb_.step == 3)
      return {values<3>(0, row, x, rgb_.red), values<3>(0, row, x, 1), values<3>(0, row, x, rgb_.blue)};
    if (rgb_.step == 1) {
      const Floats grey = values<1>(0, row, x, 0);
      return {grey, grey, grey};
    }
    switch (p.layout) {
      case PixelLayout::yuyv:
        return converted(values<2>(0, row, x, 0), values<4, 2>(0, row, x, 1), values<4, 2>(0, row, x, 3));
      case PixelLayout::uyvy:
        return converted(values<2>(0, row, x, 1), values<4, 2>(0, row, x, 0), values<4, 2>(0, row, x, 2));
      case PixelLayout::nv12:
        return converted(values<1>(0, row, x, 0), values<2, 2>(1, row / 2, x, 0), values<2, 2>(1, row / 2, x, 1));
      case PixelLayout::i444:
        return converted(values<1>(0, row, x, 0), values<1>(1, row, x, 0), values<1>(2, row, x, 0));
      default: {
        const int below = p.layout == PixelLayout::i420 ? row / 2 : row;
        return converted(values<1>(0, row, x, 0), values<1, 2>(1, below, x, 0), values<1, 2>(2, below, x, 0));
      }
    }
  }

 private:
  // Of a plane's row: a byte every `step`, for `repeat` pixels each, the first at `first`.
  template <int step, int repeat = 1>
  Floats values(std::size_t plane, int row, int x, std::size_t first) const {
    const Plane& of = picture_->planes[plane];
    const std::uint8_t* bytes = of.data + static_cast<std::size_t>(row) * of.stride + first;
    const bool inside = x >= 0 && x + kEight <= picture_->width;
    std::uint64_t eight = 0;
    if (inside && step == 1 && repeat == 1)
      std::memcpy(&eight, bytes + x, sizeof eight);
    else
      for (int i = 0; i < kEight; i += repeat) {
        const int at = inside ? x + i : std::clamp(x + i, 0, picture_->width - 1);
        eight |= std::uint64_t{bytes[at / repeat * step]} << 8 * i;
      }
    if (repeat == 2) eight |= eight << 8;  // an odd picture's last pixel is the first of its pair
    using Bytes = std::uint8_t __attribute__((vector_size(kLanes)));
    const auto found = __builtin_convertvector(loaded<Bytes>(&eight), Integers);
    return __builtin_convertvector(found, Floats) * (1.0F / 255.0F);  // as GL reads 8-bit texels
  }
  std::array<Floats, 3> converted(Floats y, Floats u, Floats v) const {
    y -= matrix_.offset.x;
    u -= matrix_.offset.y;
    v -= matrix_.offset.z;
    const auto value = [&](std::size_t c) {
      return matrix_.rows[c].x * y + matrix_.rows[c].y * u + matrix_.rows[c].z * v;
    };
    return {value(0), value(1), value(2)};
  }

  const PictureView* picture_;
  YuvToRgb matrix_;
  RgbBytes rgb_;
};

}  // namespace kasumi
