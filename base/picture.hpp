// Views of 8-bit camera pictures as drivers deliver them: planes in memory, not owned.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

#include "base/image.hpp"

namespace kasumi {

enum class PixelLayout {
  rgb8,   // one plane, R G B
  bgr8,   // one plane, B G R
  rgba8,  // one plane, R G B x
  bgra8,  // one plane, B G R x
  grey8,  // one plane
  yuyv,   // one plane, Y0 U Y1 V
  uyvy,   // one plane, U Y0 V Y1
  nv12,   // Y; interleaved U V at half width and half height
  i420,   // Y; U; V at half width and half height
  i422,   // Y; U; V at half width
  i444,   // Y; U; V at full size
};
std::string_view name_of(PixelLayout layout);
int plane_count(PixelLayout layout);

// Which matrix and range turn the planes' Y, U, V into R'G'B'. JPEG is bt601_full. Ignored for RGB layouts.
enum class YuvEncoding { bt601_full, bt601_limited, bt709_full, bt709_limited };
std::string_view name_of(YuvEncoding encoding);

struct Plane {
  const std::uint8_t* data = nullptr;
  std::size_t stride = 0;  // bytes from one row to the next
};

struct PictureView {
  PixelLayout layout = PixelLayout::rgb8;
  YuvEncoding encoding = YuvEncoding::bt601_full;
  int width = 0;
  int height = 0;
  std::array<Plane, 3> planes{};
};

// Width in bytes and height in rows of a plane (chroma planes of odd sizes are rounded up).
struct PlaneSize {
  std::size_t row_bytes = 0;
  int rows = 0;
};
PlaneSize plane_size(PixelLayout layout, int width, int height, int plane);

using Rgb8 = glm::u8vec3;

// The conversion used on both GPU and CPU: rgb = matrix * (yuv - offset), yuv and rgb in 0..1.
struct YuvToRgb {
  glm::vec3 offset;
  std::array<glm::vec3, 3> rows;  // R, G, B
};
YuvToRgb yuv_to_rgb(YuvEncoding encoding);

// One pixel as encoded R'G'B' in 0..255, chroma taken from the nearest sample.
Rgb8 rgb_at(const PictureView& picture, int x, int y);
// The whole picture, chroma from the nearest sample.
Image<Rgb8> to_rgb(const PictureView& picture);

// A picture that owns its planes: it stays valid after the driver has its buffer back.
class CopiedPicture {
 public:
  explicit CopiedPicture(const PictureView& picture);
  const PictureView& view() const { return view_; }

 private:
  PictureView view_;
  std::shared_ptr<const std::vector<std::uint8_t>> bytes_;  // copies of this object share them
};

// A view of an RGB image, which must outlive it.
PictureView view_of(const Image<Rgb8>& image);

}  // namespace kasumi
