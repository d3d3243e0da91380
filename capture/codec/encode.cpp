#include "capture/codec/encode.hpp"

#include <algorithm>
#include <cmath>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

namespace kasumi {

namespace {

std::uint8_t to_byte(float value) {
  return static_cast<std::uint8_t>(std::clamp(std::lround(value), 0l, 255l));
}

struct Yuv8 {
  std::uint8_t y, u, v;
};

// Reads an RGB picture as Y, U, V samples of any size.
class YuvReader {
 public:
  YuvReader(const Image<Rgb8>& image, YuvEncoding encoding) : image_(image) {
    const auto to_rgb = yuv_to_rgb(encoding);
    from_rgb_ = glm::inverse(glm::transpose(glm::mat3{to_rgb.rows[0], to_rgb.rows[1], to_rgb.rows[2]}));
    offset_ = 255.0f * to_rgb.offset;
  }
  // The mean over the part of a block of pixels inside the picture.
  Yuv8 mean(int x, int y, int width, int height) const {
    glm::vec3 sum{0.0f};
    float count = 0.0f;
    for (int row = y; row < std::min(y + height, image_.height()); ++row)
      for (int column = x; column < std::min(x + width, image_.width()); ++column, ++count)
        sum += glm::vec3{image_.at(column, row)};
    const auto yuv = from_rgb_ * (sum / count) + offset_;
    return {to_byte(yuv.x), to_byte(yuv.y), to_byte(yuv.z)};
  }
  std::uint8_t luma(int x, int y) const { return mean(x, y, 1, 1).y; }
  // Packed 4:2:2 repeats the last pixel of an odd row.
  std::uint8_t luma_or_last(int x, int y) const { return luma(std::min(x, image_.width() - 1), y); }

 private:
  const Image<Rgb8>& image_;
  glm::mat3 from_rgb_{};
  glm::vec3 offset_{};
};

struct Rows {
  std::uint8_t* first;
  std::size_t stride;
  std::uint8_t* row(int y) const { return first + static_cast<std::size_t>(y) * stride; }
};

// `order`: the channel (0 R, 1 G, 2 B) at each byte; 3 is an opaque alpha.
void pack_rgb(const Image<Rgb8>& image, std::initializer_list<int> order, Rows rows) {
  for (int y = 0; y < image.height(); ++y) {
    auto* out = rows.row(y);
    for (int x = 0; x < image.width(); ++x)
      for (const int channel : order) *out++ = channel == 3 ? std::uint8_t{255} : image.at(x, y)[channel];
  }
}

void pack_422(const Image<Rgb8>& image, const YuvReader& yuv, bool luma_first, Rows rows) {
  for (int y = 0; y < image.height(); ++y) {
    auto* out = rows.row(y);
    for (int x = 0; x < image.width(); x += 2, out += 4) {
      const auto chroma = yuv.mean(x, y, 2, 1);
      out[luma_first ? 0 : 1] = yuv.luma(x, y);
      out[luma_first ? 2 : 3] = yuv.luma_or_last(x + 1, y);
      out[luma_first ? 1 : 0] = chroma.u;
      out[luma_first ? 3 : 2] = chroma.v;
    }
  }
}

void pack_luma(const Image<Rgb8>& image, const YuvReader& yuv, Rows rows) {
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) rows.row(y)[x] = yuv.luma(x, y);
}

// U and V of 4:2:0; `step` bytes from one sample to the next.
void pack_420_chroma(const Image<Rgb8>& image, const YuvReader& yuv, Rows u, Rows v, std::size_t step) {
  for (int y = 0; y < image.height(); y += 2)
    for (int x = 0; x < image.width(); x += 2) {
      const auto chroma = yuv.mean(x, y, 2, 2);
      const auto at = static_cast<std::size_t>(x / 2) * step;
      u.row(y / 2)[at] = chroma.u;
      v.row(y / 2)[at] = chroma.v;
    }
}

void pack(const Image<Rgb8>& image, PixelLayout layout, YuvEncoding encoding, std::uint32_t stride,
          std::vector<std::uint8_t>& bytes) {
  const YuvReader yuv(image, encoding);
  std::array<Rows, 3> planes{};
  std::size_t offset = 0;
  for (int i = 0; i < plane_count(layout); ++i) {
    const std::size_t plane_stride = stride_of_plane(layout, stride, i);
    planes[static_cast<std::size_t>(i)] = {bytes.data() + offset, plane_stride};
    offset += plane_stride * static_cast<std::size_t>(plane_size(layout, image.width(), image.height(), i).rows);
  }
  switch (layout) {
    case PixelLayout::rgb8: return pack_rgb(image, {0, 1, 2}, planes[0]);
    case PixelLayout::bgr8: return pack_rgb(image, {2, 1, 0}, planes[0]);
    case PixelLayout::rgba8: return pack_rgb(image, {0, 1, 2, 3}, planes[0]);
    case PixelLayout::bgra8: return pack_rgb(image, {2, 1, 0, 3}, planes[0]);
    case PixelLayout::grey8: return pack_luma(image, yuv, planes[0]);
    case PixelLayout::yuyv: return pack_422(image, yuv, true, planes[0]);
    case PixelLayout::uyvy: return pack_422(image, yuv, false, planes[0]);
    case PixelLayout::nv12:
      pack_luma(image, yuv, planes[0]);
      return pack_420_chroma(image, yuv, planes[1], {planes[1].first + 1, planes[1].stride}, 2);
    case PixelLayout::i420:
      pack_luma(image, yuv, planes[0]);
      return pack_420_chroma(image, yuv, planes[1], planes[2], 1);
    case PixelLayout::i422:
    case PixelLayout::i444: return;  // no camera format has them
  }
}

}  // namespace

Result<Frame> encode_frame(const Image<Rgb8>& image, FourCc format, const EncodingFormat& options) {
  FrameMetadata metadata;
  metadata.format = format;
  metadata.width = image.width();
  metadata.height = image.height();
  const auto layout = layout_of(format);
  if (layout)
    metadata.stride = options.stride != 0
                          ? options.stride
                          : static_cast<std::uint32_t>(plane_size(*layout, image.width(), image.height(), 0).row_bytes);
  if (auto possible = check_geometry(metadata); !possible) return fail(possible.error());

  std::vector<std::uint8_t> bytes;
  if (layout) {
    bytes.resize(bytes_needed(metadata));
    pack(image, *layout, options.yuv_encoding, metadata.stride, bytes);
  } else {
    auto jpeg = encode_jpeg(image, options.jpeg_quality, options.jpeg_subsampling);
    if (!jpeg) return fail(jpeg.error());
    bytes = std::move(*jpeg);
  }
  metadata.bytes_used = static_cast<std::uint32_t>(bytes.size());
  return Frame{metadata, payload_of(std::move(bytes))};
}

}  // namespace kasumi
