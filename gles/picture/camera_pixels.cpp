#include "gles/picture/camera_pixels.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "gles/picture/wide_vectors.hpp"

namespace kasumi {
namespace {

static_assert(std::endian::native == std::endian::little);

// A row's luma and chroma, a value a pixel, and as many more as make the last vector whole.
struct YuvRow {
  std::vector<float> y, u, v;
  explicit YuvRow(std::size_t width) : y(width + kLanes), u(width + kLanes), v(width + kLanes) {}
};

// Where the values of a row lie.
struct PlaneRow {
  const std::uint8_t* first;
  float offset;
};

// The first of each run of `step` bytes, for `repeat` pixels each.
template <std::size_t step, std::size_t repeat>
void spread(PlaneRow from, std::size_t width, std::vector<float>& to) {
  const std::uint8_t* __restrict bytes = from.first;
  float* __restrict values = to.data();
  for (std::size_t i = 0; i < (width + repeat - 1) / repeat; ++i)
    for (std::size_t k = 0; k < repeat; ++k) values[repeat * i + k] = static_cast<float>(bytes[i * step]) - from.offset;
}

void read_row(const PictureView& p, const glm::vec3& offset, std::size_t row, YuvRow& to) {
  const auto width = static_cast<std::size_t>(p.width);
  const auto line = [&](std::size_t plane, std::size_t of) {
    return p.planes[plane].data + of * p.planes[plane].stride;
  };
  switch (p.layout) {
    case PixelLayout::yuyv:
    case PixelLayout::uyvy: {
      const std::size_t luma = p.layout == PixelLayout::yuyv ? 0 : 1;
      spread<2, 1>({line(0, row) + luma, offset.x}, width, to.y);
      spread<4, 2>({line(0, row) + 1 - luma, offset.y}, width, to.u);
      spread<4, 2>({line(0, row) + 3 - luma, offset.z}, width, to.v);
      return;
    }
    case PixelLayout::nv12:
      spread<1, 1>({line(0, row), offset.x}, width, to.y);
      spread<2, 2>({line(1, row / 2), offset.y}, width, to.u);
      spread<2, 2>({line(1, row / 2) + 1, offset.z}, width, to.v);
      return;
    case PixelLayout::i444:
      spread<1, 1>({line(0, row), offset.x}, width, to.y);
      spread<1, 1>({line(1, row), offset.y}, width, to.u);
      spread<1, 1>({line(2, row), offset.z}, width, to.v);
      return;
    default: {
      const std::size_t below = p.layout == PixelLayout::i420 ? row / 2 : row;
      spread<1, 1>({line(0, row), offset.x}, width, to.y);
      spread<1, 2>({line(1, below), offset.y}, width, to.u);
      spread<1, 2>({line(2, below), offset.z}, width, to.v);
    }
  }
}

// As to_rgb(): the same products in the same order.
void convert(const PictureView& p, Image<glm::u8vec4>& pixels) {
  const YuvToRgb m = yuv_to_rgb(p.encoding);
  const auto width = static_cast<std::size_t>(p.width);
  YuvRow line(width);
  for (int row = 0; row < p.height; ++row) {
    read_row(p, 255.0F * m.offset, static_cast<std::size_t>(row), line);
    glm::u8vec4* to = pixels.row(row);
    for (std::size_t x = 0; x < width; x += kLanes) {
      Floats y, u, v;
      std::memcpy(&y, line.y.data() + x, sizeof y);
      std::memcpy(&u, line.u.data() + x, sizeof u);
      std::memcpy(&v, line.v.data() + x, sizeof v);
      Integers channels[3];
      for (std::size_t c = 0; c < 3; ++c) {
        Floats sum = m.rows[c].x * y + m.rows[c].y * u + m.rows[c].z * v;
        sum = sum < 0.0F ? Floats{} : sum;
        sum = sum > 255.0F ? Floats{} + 255.0F : sum;
        channels[c] = __builtin_convertvector(sum + 0.5F, Integers);
      }
      const Integers whole = channels[0] | channels[1] << 8 | channels[2] << 16 | static_cast<std::int32_t>(0xff000000);
      if (width - x >= kLanes)
        std::memcpy(to + x, &whole, sizeof whole);
      else
        std::memcpy(to + x, &whole, (width - x) * sizeof *to);
    }
  }
}

}  // namespace

Result<> check_planes(const PictureView& picture) {
  Problems problems;
  if (picture.width < 1 || picture.height < 1)
    problems.add("camera picture: {} x {} pixels: expected at least 1 x 1", picture.width, picture.height);
  if (!problems.empty()) return fail(problems.fault());
  for (int i = 0; i < plane_count(picture.layout); ++i) {
    const Plane& plane = picture.planes[static_cast<std::size_t>(i)];
    const PlaneSize size = plane_size(picture.layout, picture.width, picture.height, i);
    if (plane.data == nullptr) problems.add("camera picture ({}): plane {} is missing", name_of(picture.layout), i);
    if (plane.stride < size.row_bytes)
      problems.add("camera picture ({}): plane {} has a stride of {} bytes: expected at least {}",
                   name_of(picture.layout), i, plane.stride, size.row_bytes);
  }
  if (!problems.empty()) return fail(problems.fault());
  return {};
}

Result<> KeptPlanes::take(const PictureView& picture) {
  if (auto sound = check_planes(picture); !sound) return sound;
  const auto planes = static_cast<std::size_t>(plane_count(picture.layout));
  std::array<PlaneSize, 3> sizes;
  std::size_t whole = 0;
  for (std::size_t i = 0; i < planes; ++i) {
    sizes[i] = plane_size(picture.layout, picture.width, picture.height, static_cast<int>(i));
    whole += sizes[i].row_bytes * static_cast<std::size_t>(sizes[i].rows);
  }
  bytes_.resize(whole);
  view_ = picture;
  std::uint8_t* to = bytes_.data();
  for (std::size_t i = 0; i < planes; ++i) {
    view_.planes[i] = {to, sizes[i].row_bytes};
    const std::uint8_t* from = picture.planes[i].data;
    for (int row = 0; row < sizes[i].rows; ++row, to += sizes[i].row_bytes, from += picture.planes[i].stride)
      std::memcpy(to, from, sizes[i].row_bytes);
  }
  return {};
}

void to_rgba(const PictureView& picture, Image<glm::u8vec4>& pixels) {
  if (pixels.width() != picture.width || pixels.height() != picture.height)
    pixels = Image<glm::u8vec4>(picture.width, picture.height);
  const auto width = static_cast<std::size_t>(picture.width);
  if (const RgbBytes at = rgb_bytes(picture.layout); at.step > 0) {
    for (int row = 0; row < picture.height; ++row) {
      const std::uint8_t* from = picture.planes[0].data + static_cast<std::size_t>(row) * picture.planes[0].stride;
      glm::u8vec4* to = pixels.row(row);
      for (std::size_t x = 0; x < width; ++x, from += at.step)
        to[x] = glm::u8vec4(from[at.red], from[at.green], from[at.blue], 255);
    }
    return;
  }
  run_by_widest([&] { convert(picture, pixels); });
}

}  // namespace kasumi
