// Pictures of phones and scanners, written by other people's programs (heif-enc, avifenc, ImageMagick, exiftool), and
// what else people take for pictures. Samples of Display P3 are turned into sRGB here by the matrices of SMPTE EG 432-1.
#include <array>
#include <span>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "base/picture_files/other_kinds.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr int kPatch = 32, kPatchesAcross = 3, kPatchesDown = 2;
using PatchColours = std::array<std::array<glm::vec3, kPatchesAcross>, kPatchesDown>;
// Of all three files, 96 x 64 pixels; of the second one they are Display P3's.
constexpr PatchColours kPatches{
    {{{{200, 60, 60}, {60, 160, 220}, {240, 240, 240}}}, {{{40, 120, 50}, {130, 130, 130}, {20, 20, 20}}}}};
constexpr PatchColours kPatchesFromP3{
    {{{{217.5, 41.6, 52.3}, {0, 162.6, 225.6}, {240, 240, 240}}}, {{{0, 122.1, 38.5}, {130, 130, 130}, {20, 20, 20}}}}};

std::filesystem::path phone_file(const char* name) {
  return source_folder() / "tests/pipeline/site/files/phone" / name;
}

std::span<const std::uint8_t> bytes_in(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

void expect_patches(const Photograph& photograph, const PatchColours& expected, float within) {
  ASSERT_EQ(photograph.encoded.width(), kPatch * kPatchesAcross);
  ASSERT_EQ(photograph.encoded.height(), kPatch * kPatchesDown);
  for (std::size_t row = 0; row < kPatchesDown; ++row)
    for (std::size_t column = 0; column < kPatchesAcross; ++column)
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(255.0F * photograph.encoded.at(kPatch * static_cast<int>(column) + kPatch / 2,
                                                   kPatch * static_cast<int>(row) + kPatch / 2)[c],
                    expected.at(row).at(column)[c], within)
            << column << ", " << row << ", channel " << c;
}

void expect_june_in_zurich(const TakenAt& taken) {
  ASSERT_TRUE(taken.utc && taken.place);
  EXPECT_EQ(taken.utc->time_since_epoch(), std::chrono::seconds(1561113296));  // 2019-06-21 12:34:56 +02:00
  EXPECT_NEAR(taken.place->latitude_deg, 47.504166, 1e-5);
  EXPECT_NEAR(taken.place->longitude_deg, 8.01, 1e-5);
}

TEST(PhonePictures, AHeicHasItsColoursItsTimeAndItsPlace) {
  TakenAt taken;
  const auto read = read_photograph(phone_file("phone.heic"), nullptr, &taken);
  ASSERT_TRUE(read) << read.error().message;
  expect_patches(*read, kPatches, 3.0F);
  EXPECT_DOUBLE_EQ(read->quantum, 1.0 / 255.0);
  expect_june_in_zurich(taken);
}

TEST(PhonePictures, AnAvifOfDisplayP3BecomesSrgb) {
  const auto read = read_photograph(phone_file("p3.avif"));
  ASSERT_TRUE(read) << read.error().message;
  expect_patches(*read, kPatchesFromP3, 3.0F);
}

TEST(PhonePictures, AnAvifOfTenBitsThatLiesOnItsSideIsTurned) {
  const auto read = read_photograph(phone_file("turned.avif"));
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_DOUBLE_EQ(read->quantum, 1.0 / 65535.0);
  ASSERT_EQ(read->encoded.width(), kPatch * kPatchesDown);
  ASSERT_EQ(read->encoded.height(), kPatch * kPatchesAcross);
  // A quarter turn counter-clockwise (ISO/IEC 23008-12, 6.5.10): the corner at the top right comes to the top left.
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(255.0F * read->encoded.at(kPatch / 2, kPatch / 2)[c], kPatches[0][2][c], 3.0F);
    EXPECT_NEAR(255.0F * read->encoded.at(kPatch / 2, 5 * kPatch / 2)[c], kPatches[0][0][c], 3.0F);
  }
}

TEST(PhonePictures, ADamagedHeicIsRefusedInWords) {
  auto bytes = read_file(phone_file("phone.heic")).value();
  const auto file = test_output_folder() / "cut.heic";
  for (const std::size_t kept : {bytes.size() - 40, bytes.size() / 2, std::size_t{40}}) {
    ASSERT_TRUE(write_file(file, std::span(bytes).first(kept)));
    const auto read = read_photograph(file);
    ASSERT_FALSE(read) << kept;
    EXPECT_EQ(read.error().kind, FaultKind::bad_input) << read.error().message;
    EXPECT_THAT(read.error().message, HasSubstr("cut.heic"));
  }
}

TEST(PhonePictures, ATiffHasItsTimeAndItsPlaceAndKeepsThem) {
  TakenAt taken;
  const auto read = read_photograph(phone_file("scanned.tif"), nullptr, &taken);
  ASSERT_TRUE(read) << read.error().message;
  expect_patches(*read, kPatches, 0.5F);
  expect_june_in_zurich(taken);
  const auto written = test_output_folder() / "written.tiff";
  ASSERT_TRUE(write_photograph(written, *read));
  TakenAt again;
  const auto as_written = read_photograph(written, nullptr, &again);
  ASSERT_TRUE(as_written) << as_written.error().message;
  expect_patches(*as_written, kPatches, 0.5F);
  expect_june_in_zurich(again);
}

TEST(PhonePictures, APamHasRedWhereItIsRed) {
  const auto file = test_output_folder() / "red.pam";
  const std::string pam = "P7\nWIDTH 2\nHEIGHT 1\nDEPTH 3\nMAXVAL 255\nTUPLTYPE RGB\nENDHDR\n\xc8\x32\x0a\x0a\x32\xc8";
  ASSERT_TRUE(write_file(file, bytes_in(pam)));
  const auto read = read_photograph(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(to_rgb8(*read).at(0, 0), Rgb8(200, 50, 10));
  EXPECT_EQ(to_rgb8(*read).at(1, 0), Rgb8(10, 50, 200));
}

TEST(PhonePictures, WhatIsNoPictureIsNamed) {
  using std::string_literals::operator""s;
  // A preview of the raw file: a TIFF whose first directory says that it is one, and that there are others.
  const std::string preview =
      "II*\0\x08\0\0\0\x02\0\xfe\0\x04\0\x01\0\0\0\x01\0\0\0\x4a\x01\x04\0\x01\0\0\0\x40\0\0\0\0\0\0\0"s;
  const std::string dng = "MM\0*\0\0\0\x08\0\x01\xc6\x12\0\x01\0\0\0\x04\x01\x04\0\0\0\0\0\0"s;
  const std::pair<std::string, std::string> kinds[] = {
      {"GIF89a\1\0\1\0"s, "a GIF: expected PNG, JPEG"},
      {"\0\0\0\x0cJXL \r\n\x87\n"s, "a JPEG XL: expected"},
      {"\0\0\0\x0cjP  \r\n\x87\n"s, "a JPEG 2000: expected"},
      {"8BPS\0\1"s, "a Photoshop document: expected"},
      {"%PDF-1.7"s, "a PDF: expected"},
      {"\0\0\0\x18"
       "ftypisom"s,
       "a film: expected"},
      {"\xef\xbb\xbf<!DOCTYPE html><html><title>404</title>"s, "a web page"},
      {"<?xml version='1.0'?><svg xmlns='http://www.w3.org/2000/svg'/>"s, "an SVG: expected"},
      {"version https://git-lfs.github.com/spec/v1\noid sha256:aa\n"s, "a pointer of Git LFS"},
      {"II*\0\x10\0\0\0CR\2\0"s, "a camera's raw file"},
      {"FUJIFILMCCD-RAW 0201"s, "a camera's raw file"},
      {preview, "a camera's raw file"},
      {dng, "a camera's raw file"},
      {"", "an empty file"},
  };
  for (const auto& [bytes, words] : kinds) {
    EXPECT_THAT(other_kind(bytes_in(bytes)), StartsWith(words));
    const auto file = test_output_folder() / "other";
    ASSERT_TRUE(write_file(file, bytes_in(bytes)));
    const auto read = read_photograph(file);
    ASSERT_FALSE(read) << words;
    EXPECT_THAT(read.error().message, HasSubstr("other: " + words));
  }
  // A TIFF of several pages begins with a picture.
  const auto scanned = read_file(phone_file("scanned.tif")).value();
  EXPECT_EQ(other_kind(scanned), "");
  EXPECT_EQ(other_kind(read_file(phone_file("phone.heic")).value()), "");
}

}  // namespace
}  // namespace kasumi
