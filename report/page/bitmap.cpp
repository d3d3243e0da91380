#include "report/page/bitmap.hpp"

#include <cstdint>
#include <string_view>

namespace kasumi::report {

namespace {

constexpr std::uint32_t kHeaderBytes = 14, kInfoBytes = 40, kBitsPerPixel = 24;

// RFC 4648.
std::string base64(std::string_view bytes) {
  constexpr std::string_view kLetters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kLetters[three >> (18 - 6 * k) & 63u];
  }
  return text;
}

}  // namespace

std::string bitmap_address(const Image<Rgb8>& picture) {
  std::string bytes;
  const auto add = [&](std::uint32_t value, int size) {  // its lowest byte first
    for (int i = 0; i < size; ++i) bytes += static_cast<char>(value >> 8 * i & 255u);
  };
  const auto width = static_cast<std::uint32_t>(picture.width()), height = static_cast<std::uint32_t>(picture.height());
  const std::uint32_t row_bytes = (3 * width + 3) / 4 * 4, before = kHeaderBytes + kInfoBytes;
  bytes += "BM";
  for (const std::uint32_t value : {before + row_bytes * height, 0u, before, kInfoBytes, width, height}) add(value, 4);
  for (const std::uint32_t value : {1u, kBitsPerPixel}) add(value, 2);
  for (const std::uint32_t value : {0u, row_bytes * height, 0u, 0u, 0u, 0u}) add(value, 4);
  for (int y = picture.height() - 1; y >= 0; --y) {  // the lowest row first
    for (int x = 0; x < picture.width(); ++x)
      for (const int c : {2, 1, 0}) bytes += static_cast<char>(picture.at(x, y)[c]);
    bytes.append(row_bytes - 3 * width, '\0');
  }
  return "data:image/bmp;base64," + base64(bytes);
}

}  // namespace kasumi::report
