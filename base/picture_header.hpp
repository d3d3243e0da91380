// What a picture's file says of its size, read before anything is decoded: a file of some kilobytes may claim more
// pixels than there is memory for.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "base/result.hpp"

namespace kasumi {

struct PictureHeader {
  std::string_view format;  // "PNG", "JPEG", "TIFF", "PNM", "PFM", "EXR", "HDR", "BMP", "WebP", "FITS", "HEIF"
  std::int64_t width = 0, height = 0;
  std::int64_t tile_pixels = 0;  // of one tile or strip of a TIFF: it is decoded as a whole
  std::int64_t scans = 1;        // of a JPEG: each may cost as much as the whole picture, and take some bytes

  bool is(int wanted_width, int wanted_height) const { return width == wanted_width && height == wanted_height; }
};

// HEIC or AVIF, a picture of its own and no film.
bool is_heif(std::span<const std::uint8_t> file);

// Empty: none of these formats, or damaged where its size stands. No other picture is handed to a decoder.
std::optional<PictureHeader> picture_header(std::span<const std::uint8_t> file);

struct PictureLimits {
  std::int64_t side_px;
  std::int64_t pixels;
  std::int64_t scans = 200;
};
constexpr PictureLimits kPhotographLimits{32'768, 160'000'000};  // more than the largest sensors have
constexpr PictureLimits kStillLimits{8'192, 36'000'000};         // more than the largest displays show

// Error (bad_input, without the file's name): larger than that, or no pixels at all.
Result<> check_size(const PictureHeader& header, const PictureLimits& limits);

}  // namespace kasumi
