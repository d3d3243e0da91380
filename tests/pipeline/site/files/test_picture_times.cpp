#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "base/utc_text.hpp"
#include "pipeline/site/files/picture_times.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

std::string time_of(const std::string& name, const PictureTimes& times = {}) {
  const auto utc = picture_time("/nowhere/" + name, times);
  return utc ? utc_text(*utc) : "none";
}

TEST(PictureTimes, UsualNamesAreUnderstood) {
  EXPECT_EQ(time_of("Alpnach_20180129_110920_05.png"), "2018-01-29T11:09:20Z");
  EXPECT_EQ(time_of("20180129110920.jpg"), "2018-01-29T11:09:20Z");
  EXPECT_EQ(time_of("cam1-20180129-110920.jpg"), "2018-01-29T11:09:20Z");
  EXPECT_EQ(time_of("2018-01-29T11-09-20.jpg"), "2018-01-29T11:09:20Z");
  EXPECT_EQ(time_of("sky 2018-01-29_11:09:20 x.jpg"), "2018-01-29T11:09:20Z");
  EXPECT_EQ(time_of("20180129_1109.jpg"), "2018-01-29T11:09:00Z");
}

TEST(PictureTimes, WhatIsNoTimeIsNone) {
  for (const char* name :
       {"IMG_1234.jpg", "sky.png", "20181301_110920.jpg", "99999999999999.jpg", "10500129_110920.jpg"})
    EXPECT_EQ(time_of(name), "none") << name;
}

TEST(PictureTimes, AFormatAndAnOffsetAreFollowed) {
  EXPECT_EQ(time_of("day29-01-2018_at_20h09.jpg", {"%d-%m-%Y_at_%Hh%M", 9.0}), "2018-01-29T11:09:00Z");
  EXPECT_EQ(time_of("20180129_110920.jpg", {"%d-%m-%Y", 0.0}), "none");
}

// A JPEG of nothing but its EXIF block, as the standard has it: little endian, one IFD, the EXIF IFD.
std::string exif_jpeg(const std::string& date, const std::string& offset) {
  const auto word = [](unsigned value) { return std::string{static_cast<char>(value), static_cast<char>(value >> 8)}; };
  const auto number = [&](unsigned value) { return word(value & 0xffff) + word(value >> 16); };
  const auto entry = [&](unsigned tag, unsigned type, unsigned count, unsigned value) {
    return word(tag) + word(type) + number(count) + number(value);
  };
  const unsigned exif = 8 + 2 + 12 + 4, entries = offset.empty() ? 1 : 2, text = exif + 2 + 12 * entries + 4;
  std::string tiff = "II*" + std::string(1, '\0') + number(8) + word(1) + entry(0x8769, 4, 1, exif) + number(0);
  tiff += word(entries) + entry(0x9003, 2, 20, text);
  if (!offset.empty()) tiff += entry(0x9011, 2, 7, text + 20);
  tiff += number(0) + date + std::string(1, '\0') + offset + std::string(1, '\0');
  const std::string block = std::string("Exif\0\0", 6) + tiff;
  const auto size = static_cast<unsigned>(block.size() + 2);
  return "\xff\xd8\xff\xe1" + std::string{static_cast<char>(size >> 8), static_cast<char>(size)} + block + "\xff\xd9";
}

TEST(PictureTimes, ExifTellsWhereTheNameDoesNot) {
  const auto folder = test_folder("picture-times");
  std::filesystem::create_directories(folder);
  const auto file = folder / "IMG.jpg";
  std::ofstream(file, std::ios::binary) << exif_jpeg("2018:01:29 20:09:20", "");
  EXPECT_EQ(utc_text(*picture_time(file, {"", 9.0})), "2018-01-29T11:09:20Z");
  std::ofstream(file, std::ios::binary) << exif_jpeg("2018:01:29 20:09:20", "+05:30");
  EXPECT_EQ(utc_text(*picture_time(file, {"", 9.0})), "2018-01-29T14:39:20Z");
  std::ofstream(file, std::ios::binary) << exif_jpeg("2018:01:29 20:09:20", "").substr(0, 40);
  EXPECT_FALSE(picture_time(file, {}));
}

}  // namespace
}  // namespace kasumi
