#include "gles/model/model_picture.hpp"

#include <array>
#include <cstring>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace kasumi {
namespace {

int big_endian(std::span<const std::uint8_t> bytes, std::size_t at, int count) {
  int value = 0;
  for (int i = 0; i < count; ++i) value = value << 8 | bytes[at + static_cast<std::size_t>(i)];
  return value;
}

std::optional<glm::ivec2> png_size(std::span<const std::uint8_t> file) {
  constexpr std::array<std::uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  if (file.size() < 24 || std::memcmp(file.data(), kSignature.data(), kSignature.size()) != 0) return std::nullopt;
  return glm::ivec2{big_endian(file, 16, 4), big_endian(file, 20, 4)};
}

std::optional<glm::ivec2> jpeg_size(std::span<const std::uint8_t> file) {
  if (file.size() < 4 || file[0] != 0xff || file[1] != 0xd8) return std::nullopt;
  for (std::size_t at = 2; at + 9 < file.size();) {
    if (file[at] != 0xff) return std::nullopt;
    const std::uint8_t marker = file[at + 1];
    if (marker == 0xff) {  // fill
      ++at;
      continue;
    }
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) return glm::ivec2{big_endian(file, at + 7, 2), big_endian(file, at + 5, 2)};
    at += 2 + static_cast<std::size_t>(big_endian(file, at + 2, 2));
  }
  return std::nullopt;
}

}  // namespace

std::optional<glm::ivec2> picture_size(std::span<const std::uint8_t> file) {
  if (const auto size = png_size(file)) return size;
  return jpeg_size(file);
}

Result<Image<glm::u8vec4>> decode_picture(std::span<const std::uint8_t> file, int largest) {
  const auto size = picture_size(file);
  if (!size) return fail(FaultKind::bad_input, "neither a PNG nor a JPEG");
  if (size->x < 1 || size->y < 1 || size->x > largest || size->y > largest)
    return fail(FaultKind::bad_input, "{} x {} pixels: expected 1 .. {} each way", size->x, size->y, largest);
  cv::Mat decoded, rgba;
  try {
    const cv::Mat bytes(1, static_cast<int>(file.size()), CV_8UC1, const_cast<std::uint8_t*>(file.data()));
    decoded = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);  // keeps alpha and ignores the EXIF orientation
    if (decoded.empty()) return fail(FaultKind::bad_input, "damaged");
    if (decoded.depth() == CV_16U) decoded.convertTo(decoded, CV_8U, 1.0 / 257.0);
    if (decoded.depth() != CV_8U) return fail(FaultKind::bad_input, "neither 8 nor 16 bits a channel");
    switch (decoded.channels()) {
      case 1: cv::cvtColor(decoded, rgba, cv::COLOR_GRAY2RGBA); break;
      case 3: cv::cvtColor(decoded, rgba, cv::COLOR_BGR2RGBA); break;
      case 4: cv::cvtColor(decoded, rgba, cv::COLOR_BGRA2RGBA); break;
      default: return fail(FaultKind::bad_input, "{} channels: expected 1, 3 or 4", decoded.channels());
    }
  } catch (const std::exception& error) {
    return fail(FaultKind::bad_input, "damaged ({})", error.what());
  }
  Image<glm::u8vec4> image(rgba.cols, rgba.rows);
  for (int y = 0; y < rgba.rows; ++y)
    std::memcpy(image.row(y), rgba.ptr(y), static_cast<std::size_t>(rgba.cols) * sizeof(glm::u8vec4));
  return image;
}

}  // namespace kasumi
