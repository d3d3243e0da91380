#include <gtest/gtest.h>

#include <initializer_list>
#include <string>
#include <vector>

#include "base/picture_header.hpp"

namespace kasumi {
namespace {

std::vector<std::uint8_t> bytes_of(std::string_view text) {
  return {text.begin(), text.end()};
}

// "P6 3 2 255" and the like need no more than their first bytes; `pieces` of the binary formats are their fields.
std::vector<std::uint8_t> joined(std::initializer_list<std::string_view> pieces) {
  std::vector<std::uint8_t> all;
  for (const auto piece : pieces) all.insert(all.end(), piece.begin(), piece.end());
  all.resize(std::max<std::size_t>(all.size(), 64));
  return all;
}

template <std::size_t N>
constexpr std::string_view raw(const char (&text)[N]) {
  return {text, N - 1};
}

void expect_size(const std::vector<std::uint8_t>& file, std::string_view format, std::int64_t width,
                 std::int64_t height) {
  const auto header = picture_header(file);
  ASSERT_TRUE(header) << format;
  EXPECT_EQ(header->format, format);
  EXPECT_EQ(header->width, width) << format;
  EXPECT_EQ(header->height, height) << format;
}

const std::vector<std::uint8_t> kPng =
    joined({raw("\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR"), raw("\0\0\x36\xb0"), raw("\0\0\x36\xb0")});
const std::vector<std::uint8_t> kTiff =
    joined({raw("II*\0\x08\0\0\0\x04\0"), raw("\0\1\3\0\1\0\0\0\x40\1\0\0"), raw("\1\1\4\0\1\0\0\0\xf0\0\0\0"),
            raw("\x42\1\4\0\1\0\0\0\0\0\1\0"), raw("\x43\1\4\0\1\0\0\0\0\0\1\0")});

TEST(PictureHeader, TellsTheSizeOfEveryFormat) {
  expect_size(kPng, "PNG", 14000, 14000);
  // A thumbnail's frame within a segment does not count; fill and a stray byte are skipped.
  expect_size(joined({raw("\xff\xd8\xff\xe1\0\x0d\xff\xc0\0\x11\x08\0\1\0\1\3\0"), raw("!\xff\xff\xc2\0\x11\x08"),
                      raw("\x01\x2c\x01\xf4\3")}),
              "JPEG", 500, 300);
  expect_size(kTiff, "TIFF", 320, 240);
  expect_size(
      joined({raw("MM\0+\0\x08\0\0"), raw("\0\0\0\0\0\0\0\x10"), raw("\0\0\0\0\0\0\0\2"),
              raw("\1\0\0\4\0\0\0\0\0\0\0\1\0\0\1\x40\0\0\0\0"), raw("\1\1\0\3\0\0\0\0\0\0\0\1\0\xf0\0\0\0\0\0\0")}),
      "TIFF", 320, 240);
  expect_size(joined({raw("\x76\x2f\x31\1\2\0\0\0"), raw("channels\0chlist\0\1\0\0\0\0"),
                      raw("dataWindow\0box2i\0\x10\0\0\0\xff\xff\xff\xff\0\0\0\0\x3e\0\0\0\x1d\0\0\0")}),
              "EXR", 64, 30);
  expect_size(joined({raw("BM\0\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0"), raw("\x40\1\0\0\x10\xff\xff\xff")}), "BMP", 320,
              240);
  expect_size(joined({raw("RIFF\0\0\0\0WEBPVP8X\x0a\0\0\0\0\0\0\0"), raw("\x3f\1\0\xef\0\0")}), "WebP", 320, 240);
  expect_size(joined({raw("RIFF\0\0\0\0WEBPVP8 \0\0\0\0\0\0\0\x9d\1\x2a"), raw("\x40\1\xf0\0")}), "WebP", 320, 240);
  expect_size(joined({raw("RIFF\0\0\0\0WEBPVP8L\0\0\0\0\x2f"), raw("\x3f\xc1\x3b\0")}), "WebP", 320, 240);
  expect_size(bytes_of("P6\n# by a program\n320 # wide\n240\n255\n"), "PNM", 320, 240);
  expect_size(bytes_of("P7\nWIDTH 320\nHEIGHT 240\nDEPTH 3\nENDHDR\n"), "PNM", 320, 240);
  expect_size(bytes_of("PF\n320 240\n-1.0\n"), "PFM", 320, 240);
  expect_size(bytes_of("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 240 +X 320\n"), "HDR", 320, 240);
}

TEST(PictureHeader, CountsTheScansOfAProgressiveJpeg) {
  const std::string_view scan = raw("\xff\xda\0\x08\1\1\0\1?\0\xff\0\xff\xd0");
  const auto scans = [&](std::string_view frame) {
    return picture_header(joined({raw("\xff\xd8"), frame, raw("\0\x0b\x08\0\x10\0\x10\1\1\x11\0"), scan, scan, scan}))
        ->scans;
  };
  EXPECT_EQ(scans("\xff\xc2"), 3);
  EXPECT_EQ(scans("\xff\xca"), 3) << "arithmetically coded";
  EXPECT_EQ(scans("\xff\xc0"), 1) << "which costs no more than its bytes";
}

TEST(PictureHeader, WhatIsNoPictureOrIsCutHasNone) {
  for (const char* text : {"", "P", "Pix", "GIF89a", "BM", "RIFF", "II*", "#?RADIANCE\n", "kasumi = 1"})
    EXPECT_FALSE(picture_header(bytes_of(text)) && picture_header(bytes_of(text))->width > 0) << text;
  for (std::size_t length = 0; length < kTiff.size(); ++length)
    for (const auto* whole : {&kPng, &kTiff})  // no read beyond the end: the sanitizers look
      (void)picture_header(std::span(*whole).first(std::min(length, whole->size())));
}

TEST(PictureHeader, SizesAreBoundedWithTheNumbersThatCount) {
  const auto message = [](const PictureHeader& header, const PictureLimits& limits) {
    const auto bounded = check_size(header, limits);
    return bounded ? std::string() : bounded.error().message;
  };
  EXPECT_EQ(message({"PNG", 8192, 4320}, kStillLimits), "");
  EXPECT_EQ(message({"PNG", 14000, 14000}, kStillLimits),
            "a PNG of 14000 x 14000 pixels: expected 1 .. 8192 each way and 36 million at most");
  EXPECT_NE(message({"PNG", 14000, 14000}, kPhotographLimits), "");
  EXPECT_EQ(message({"JPEG", 14204, 10652}, kPhotographLimits), "") << "151 million, of the largest sensor sold";
  EXPECT_NE(message({"PNG", 0, 10}, kPhotographLimits), "");
  EXPECT_NE(message({"PNG", 4294967295, 4294967295}, kPhotographLimits), "");
  EXPECT_EQ(message({"JPEG", 100, 100, 0, 200}, kPhotographLimits), "");
  EXPECT_EQ(message({"JPEG", 100, 100, 0, 201}, kPhotographLimits), "a JPEG of 201 scans: expected 200 at most");
  EXPECT_EQ(message(*picture_header(kTiff), kPhotographLimits),
            "a TIFF in tiles of 4295 million pixels: expected 160 million at most");
}

}  // namespace
}  // namespace kasumi
