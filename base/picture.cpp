#include "base/picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <glm/geometric.hpp>

namespace kasumi {

std::string_view name_of(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::rgb8: return "RGB";
    case PixelLayout::bgr8: return "BGR";
    case PixelLayout::rgba8: return "RGBA";
    case PixelLayout::bgra8: return "BGRA";
    case PixelLayout::grey8: return "GREY";
    case PixelLayout::yuyv: return "YUYV";
    case PixelLayout::uyvy: return "UYVY";
    case PixelLayout::nv12: return "NV12";
    case PixelLayout::i420: return "I420";
    case PixelLayout::i422: return "I422";
    case PixelLayout::i444: return "I444";
  }
  return "unknown";
}

std::string_view name_of(YuvEncoding encoding) {
  switch (encoding) {
    case YuvEncoding::bt601_full: return "bt601_full";
    case YuvEncoding::bt601_limited: return "bt601_limited";
    case YuvEncoding::bt709_full: return "bt709_full";
    case YuvEncoding::bt709_limited: return "bt709_limited";
  }
  return "unknown";
}

int plane_count(PixelLayout layout) {
  switch (layout) {
    case PixelLayout::nv12: return 2;
    case PixelLayout::i420:
    case PixelLayout::i422:
    case PixelLayout::i444: return 3;
    default: return 1;
  }
}

PlaneSize plane_size(PixelLayout layout, int width, int height, int plane) {
  const auto w = static_cast<std::size_t>(width);
  const std::size_t half_w = (w + 1) / 2;
  const int half_h = (height + 1) / 2;
  switch (layout) {
    case PixelLayout::rgb8:
    case PixelLayout::bgr8: return {3 * w, height};
    case PixelLayout::rgba8:
    case PixelLayout::bgra8: return {4 * w, height};
    case PixelLayout::grey8: return {w, height};
    case PixelLayout::yuyv:
    case PixelLayout::uyvy: return {4 * half_w, height};
    case PixelLayout::nv12: return plane == 0 ? PlaneSize{w, height} : PlaneSize{2 * half_w, half_h};
    case PixelLayout::i420: return plane == 0 ? PlaneSize{w, height} : PlaneSize{half_w, half_h};
    case PixelLayout::i422: return plane == 0 ? PlaneSize{w, height} : PlaneSize{half_w, height};
    case PixelLayout::i444: return {w, height};
  }
  return {};
}

YuvToRgb yuv_to_rgb(YuvEncoding encoding) {
  const bool bt709 = encoding == YuvEncoding::bt709_full || encoding == YuvEncoding::bt709_limited;
  const bool limited = encoding == YuvEncoding::bt601_limited || encoding == YuvEncoding::bt709_limited;
  const float kr = bt709 ? 0.2126f : 0.299f;
  const float kb = bt709 ? 0.0722f : 0.114f;
  const float kg = 1.0f - kr - kb;
  const float luma = limited ? 255.0f / 219.0f : 1.0f;
  const float chroma = limited ? 255.0f / 224.0f : 1.0f;
  const float rv = chroma * 2.0f * (1.0f - kr);
  const float bu = chroma * 2.0f * (1.0f - kb);
  return {{limited ? 16.0f / 255.0f : 0.0f, 128.0f / 255.0f, 128.0f / 255.0f},
          {glm::vec3{luma, 0.0f, rv}, glm::vec3{luma, -bu * kb / kg, -rv * kr / kg}, glm::vec3{luma, bu, 0.0f}}};
}

namespace {

Rgb8 convert(const YuvToRgb& matrix, std::uint8_t y, std::uint8_t u, std::uint8_t v) {
  const glm::vec3 yuv = glm::vec3{y, u, v} - 255.0f * matrix.offset;
  Rgb8 rgb;
  for (int c = 0; c < 3; ++c)
    rgb[c] = static_cast<std::uint8_t>(
        std::clamp(std::lround(glm::dot(matrix.rows[static_cast<std::size_t>(c)], yuv)), 0l, 255l));
  return rgb;
}

Rgb8 pixel(const PictureView& p, const YuvToRgb& matrix, int px, int py) {
  const auto x = static_cast<std::size_t>(px), y = static_cast<std::size_t>(py);
  const auto at = [&](std::size_t plane, std::size_t byte, std::size_t row) {
    return p.planes[plane].data[row * p.planes[plane].stride + byte];
  };
  switch (p.layout) {
    case PixelLayout::rgb8: return {at(0, 3 * x, y), at(0, 3 * x + 1, y), at(0, 3 * x + 2, y)};
    case PixelLayout::bgr8: return {at(0, 3 * x + 2, y), at(0, 3 * x + 1, y), at(0, 3 * x, y)};
    case PixelLayout::rgba8: return {at(0, 4 * x, y), at(0, 4 * x + 1, y), at(0, 4 * x + 2, y)};
    case PixelLayout::bgra8: return {at(0, 4 * x + 2, y), at(0, 4 * x + 1, y), at(0, 4 * x, y)};
    case PixelLayout::grey8: return Rgb8{at(0, x, y)};
    case PixelLayout::yuyv: return convert(matrix, at(0, 2 * x, y), at(0, x / 2 * 4 + 1, y), at(0, x / 2 * 4 + 3, y));
    case PixelLayout::uyvy: return convert(matrix, at(0, 2 * x + 1, y), at(0, x / 2 * 4, y), at(0, x / 2 * 4 + 2, y));
    case PixelLayout::nv12: return convert(matrix, at(0, x, y), at(1, x / 2 * 2, y / 2), at(1, x / 2 * 2 + 1, y / 2));
    case PixelLayout::i420: return convert(matrix, at(0, x, y), at(1, x / 2, y / 2), at(2, x / 2, y / 2));
    case PixelLayout::i422: return convert(matrix, at(0, x, y), at(1, x / 2, y), at(2, x / 2, y));
    case PixelLayout::i444: return convert(matrix, at(0, x, y), at(1, x, y), at(2, x, y));
  }
  return {};
}

}  // namespace

Rgb8 rgb_at(const PictureView& picture, int x, int y) {
  return pixel(picture, yuv_to_rgb(picture.encoding), x, y);
}

Image<Rgb8> to_rgb(const PictureView& picture) {
  Image<Rgb8> image(picture.width, picture.height);
  const YuvToRgb matrix = yuv_to_rgb(picture.encoding);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) image.at(x, y) = pixel(picture, matrix, x, y);
  return image;
}

CopiedPicture::CopiedPicture(const PictureView& picture) : view_(picture) {
  std::size_t whole = 0;
  const auto planes = static_cast<std::size_t>(plane_count(picture.layout));
  const auto size_of = [&](std::size_t plane) {
    return plane_size(picture.layout, picture.width, picture.height, static_cast<int>(plane));
  };
  for (std::size_t i = 0; i < planes; ++i) whole += size_of(i).row_bytes * static_cast<std::size_t>(size_of(i).rows);
  auto bytes = std::make_shared<std::vector<std::uint8_t>>(whole);
  std::uint8_t* to = bytes->data();
  for (std::size_t i = 0; i < planes; ++i) {
    const auto size = size_of(i);
    view_.planes[i] = {to, size.row_bytes};
    for (int y = 0; y < size.rows; ++y, to += size.row_bytes)
      std::memcpy(to, picture.planes[i].data + static_cast<std::size_t>(y) * picture.planes[i].stride, size.row_bytes);
  }
  bytes_ = std::move(bytes);
}

PictureView view_of(const Image<Rgb8>& image) {
  static_assert(sizeof(Rgb8) == 3);
  PictureView view{PixelLayout::rgb8, YuvEncoding::bt601_full, image.width(), image.height(), {}};
  if (!image.empty()) view.planes[0] = {&image.elements().front().x, 3 * static_cast<std::size_t>(image.width())};
  return view;
}

}  // namespace kasumi
