// Pictures as phones, scanners and painting programs write them. Their tags are put in byte by byte, what they mean is
// computed here from EXIF's and Display P3's own definitions.
#include <algorithm>
#include <cmath>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcms2.h>
#include <zlib.h>
#include <glm/vec2.hpp>
#include <opencv2/imgcodecs.hpp>

#include "base/files.hpp"
#include "base/picture_files/embedded_tags.hpp"
#include "base/picture_files/upright_picture.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "pipeline/site/files/picture_times.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using SeenBytes = std::vector<std::uint8_t>;

std::filesystem::path seen_folder() {
  const auto path = test_output_folder() / "seen-pictures";
  std::filesystem::create_directories(path);
  return path;
}

void append(SeenBytes& to, const void* from, std::size_t size) {
  const auto* bytes = static_cast<const std::uint8_t*>(from);
  to.insert(to.end(), bytes, bytes + size);
}
void append_big(SeenBytes& to, std::uint32_t value, int count) {
  for (int i = count - 1; i >= 0; --i) to.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

SeenBytes encoded(const cv::Mat& picture, const char* ending) {
  SeenBytes bytes;
  EXPECT_TRUE(cv::imencode(ending, picture, bytes, {cv::IMWRITE_JPEG_QUALITY, 100}));
  return bytes;
}
SeenBytes with_chunk(SeenBytes png, const char* name, const SeenBytes& content) {
  SeenBytes chunk;
  append_big(chunk, static_cast<std::uint32_t>(content.size()), 4);
  append(chunk, name, 4);
  append(chunk, content.data(), content.size());
  append_big(chunk, static_cast<std::uint32_t>(crc32(0, chunk.data() + 4, static_cast<uInt>(content.size() + 4))), 4);
  png.insert(png.begin() + 33, chunk.begin(), chunk.end());  // behind IHDR
  return png;
}
SeenBytes with_segment(SeenBytes jpeg, int marker, const SeenBytes& content) {
  SeenBytes segment{0xff, static_cast<std::uint8_t>(marker)};
  append_big(segment, static_cast<std::uint32_t>(content.size() + 2), 2);
  append(segment, content.data(), content.size());
  jpeg.insert(jpeg.begin() + 2, segment.begin(), segment.end());
  return jpeg;
}
SeenBytes headed(const char* head, std::size_t length, const SeenBytes& content) {
  SeenBytes all;
  append(all, head, length);
  append(all, content.data(), content.size());
  return all;
}

SeenBytes orientation_exif(int orientation, bool big_endian) {
  SeenBytes exif;
  if (big_endian)
    append(exif, "MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0", 19);
  else
    append(exif, "II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0", 18);
  exif.push_back(static_cast<std::uint8_t>(orientation));
  exif.insert(exif.end(), big_endian ? 6 : 7, 0);
  return exif;
}

// A TIFF, little-endian as OpenCV writes it, with its directory again at the end and tag 274 in it.
SeenBytes with_orientation(SeenBytes tiff, int orientation) {
  const auto number = [&](std::size_t at, int count) {
    std::size_t value = 0;
    for (int i = count - 1; i >= 0; --i) value = value << 8 | tiff[at + static_cast<std::size_t>(i)];
    return value;
  };
  const std::size_t old = number(4, 4), count = number(old, 2);
  std::map<std::size_t, SeenBytes> entries;
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = tiff.begin() + static_cast<std::ptrdiff_t>(old + 2 + 12 * i);
    entries[number(old + 2 + 12 * i, 2)] = SeenBytes(at, at + 12);
  }
  entries[274] = {0x12, 0x01, 3, 0, 1, 0, 0, 0, static_cast<std::uint8_t>(orientation), 0, 0, 0};
  tiff.resize(tiff.size() + tiff.size() % 2);
  for (int i = 0; i < 4; ++i) tiff[4 + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(tiff.size() >> (8 * i));
  tiff.push_back(static_cast<std::uint8_t>(entries.size()));
  tiff.push_back(0);
  for (const auto& [tag, entry] : entries) tiff.insert(tiff.end(), entry.begin(), entry.end());
  tiff.insert(tiff.end(), 4, 0);
  return tiff;
}

// 3 x 2 blocks of colours, large enough for JPEG to keep them.
constexpr int kBlock = 32, kAcross = 3, kDown = 2;
cv::Vec3b block_colour(int column, int row) {  // B G R
  return {static_cast<std::uint8_t>(40 + 60 * column), static_cast<std::uint8_t>(200 - 100 * row),
          static_cast<std::uint8_t>(30 + 30 * (column + kAcross * row))};
}
cv::Mat blocks() {
  cv::Mat picture(kDown * kBlock, kAcross * kBlock, CV_8UC3);
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) picture.at<cv::Vec3b>(y, x) = block_colour(x / kBlock, y / kBlock);
  return picture;
}
// EXIF 2.32, tag 274: which side of the scene the file's first row and first column are.
glm::ivec2 place_in_file(int orientation, int column, int row, int columns, int rows) {
  const int last_column = columns - 1 - column, last_row = rows - 1 - row;
  switch (orientation) {
    case 2: return {last_column, row};       // row 0 is the top, column 0 the right
    case 3: return {last_column, last_row};  // bottom, right
    case 4: return {column, last_row};       // bottom, left
    case 5: return {row, column};            // left, top
    case 6: return {row, last_column};       // right, top
    case 7: return {last_row, last_column};  // right, bottom
    case 8: return {last_row, column};       // left, bottom
    default: return {column, row};
  }
}

TEST(UprightPicture, IsTurnedAsExifSays) {
  cv::Mat fine;
  blocks().convertTo(fine, CV_16U, 257.0);
  for (int orientation = 1; orientation <= 8; ++orientation)
    for (const char* ending : {".jpg", ".png", "16.png", ".tiff", "16.tiff"}) {
      const bool sixteen = ending[0] == '1';
      auto bytes = encoded(sixteen ? fine : blocks(), sixteen ? ending + 2 : ending);
      const auto exif = orientation_exif(orientation, orientation % 2 == 0);
      if (std::string(ending).ends_with(".jpg")) bytes = with_segment(bytes, 0xe1, headed("Exif\0\0", 6, exif));
      if (std::string(ending).ends_with(".png")) bytes = with_chunk(bytes, "eXIf", exif);
      if (std::string(ending).ends_with(".tiff")) bytes = with_orientation(std::move(bytes), orientation);
      const auto file = seen_folder() / (std::string("turned") + ending);
      ASSERT_TRUE(write_file(file, bytes));
      const auto seen = must(read_photograph(file));
      const bool upright = orientation < 5;
      const int columns = upright ? kAcross : kDown, rows = upright ? kDown : kAcross;
      ASSERT_EQ(seen->encoded.width(), columns * kBlock) << ending << orientation;
      for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
          const auto in_file = place_in_file(orientation, column, row, columns, rows);
          const auto wanted = block_colour(in_file.x, in_file.y);
          const auto is = seen->encoded.at(column * kBlock + kBlock / 2, row * kBlock + kBlock / 2);
          for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(is[c], wanted[2 - c] / 255.0F, 0.012F) << ending << " " << orientation << ": " << column << row;
        }
    }
}

SeenBytes profile_bytes(cmsHPROFILE profile) {
  cmsUInt32Number size = 0;
  cmsSaveProfileToMem(profile, nullptr, &size);
  SeenBytes bytes(size);
  EXPECT_TRUE(cmsSaveProfileToMem(profile, bytes.data(), &size));
  cmsCloseProfile(profile);
  return bytes;
}
// Display P3: DCI-P3's primaries, D65, sRGB's curve.
SeenBytes display_p3() {
  const cmsFloat64Number curve[] = {2.4, 1.0 / 1.055, 0.055 / 1.055, 1.0 / 12.92, 0.04045};
  auto* tone = cmsBuildParametricToneCurve(nullptr, 4, curve);
  cmsToneCurve* tones[] = {tone, tone, tone};
  const cmsCIExyY white{0.3127, 0.3290, 1.0};
  const cmsCIExyYTRIPLE primaries{{0.680, 0.320, 1.0}, {0.265, 0.690, 1.0}, {0.150, 0.060, 1.0}};
  auto bytes = profile_bytes(cmsCreateRGBProfile(&white, &primaries, tones));
  cmsFreeToneCurve(tone);
  return bytes;
}
SeenBytes iccp(const SeenBytes& profile) {
  uLongf size = compressBound(profile.size());
  SeenBytes packed(size);
  EXPECT_EQ(compress(packed.data(), &size, profile.data(), profile.size()), Z_OK);
  packed.resize(size);
  return headed("p\0\0", 3, packed);
}

double p3_curve_to_light(double v) {
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}
double light_to_srgb(double v) {
  v = std::clamp(v, 0.0, 1.0);
  return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055;
}
// CSS Color 4's matrices, multiplied.
glm::dvec3 p3_to_srgb(const glm::dvec3& p3) {
  const glm::dvec3 l{p3_curve_to_light(p3.r), p3_curve_to_light(p3.g), p3_curve_to_light(p3.b)};
  return {light_to_srgb(1.2249402 * l.r - 0.2249402 * l.g), light_to_srgb(-0.0420570 * l.r + 1.0420570 * l.g),
          light_to_srgb(-0.0196376 * l.r - 0.0786361 * l.g + 1.0982736 * l.b)};
}

TEST(UprightPicture, ColoursOfAProfileBecomeSrgb) {
  const auto profile = display_p3();
  const auto half = static_cast<std::ptrdiff_t>(profile.size() / 2);
  auto jpeg = encoded(blocks(), ".jpg");
  // Its parts in the wrong order.
  jpeg = with_segment(jpeg, 0xe2, headed("ICC_PROFILE\0\x01\x02", 14, {profile.begin(), profile.begin() + half}));
  jpeg = with_segment(jpeg, 0xe2, headed("ICC_PROFILE\0\x02\x02", 14, {profile.begin() + half, profile.end()}));
  cv::Mat fine;
  blocks().convertTo(fine, CV_16U, 257.0);
  const std::map<std::string, SeenBytes> files{{"p3.png", with_chunk(encoded(blocks(), ".png"), "iCCP", iccp(profile))},
                                               {"p3-16.png", with_chunk(encoded(fine, ".png"), "iCCP", iccp(profile))},
                                               {"p3.jpg", jpeg}};
  for (const auto& [name, bytes] : files) {
    ASSERT_TRUE(write_file(seen_folder() / name, bytes));
    const auto seen = must(read_photograph(seen_folder() / name));
    EXPECT_DOUBLE_EQ(seen->quantum, name == "p3-16.png" ? 1.0 / 65535.0 : 1.0 / 255.0);
    double moved = 0.0;
    for (int row = 0; row < kDown; ++row)
      for (int column = 0; column < kAcross; ++column) {
        const auto bgr = block_colour(column, row);
        const glm::dvec3 p3{bgr[2] / 255.0, bgr[1] / 255.0, bgr[0] / 255.0}, wanted = p3_to_srgb(p3);
        const auto is = seen->encoded.at(column * kBlock + kBlock / 2, row * kBlock + kBlock / 2);
        for (int c = 0; c < 3; ++c) {
          EXPECT_NEAR(is[c], wanted[c], name == "p3.jpg" ? 0.015 : 0.003) << name << " " << column << row << c;
          moved = std::max(moved, std::abs(wanted[c] - p3[c]));
        }
      }
    EXPECT_GT(moved, 0.1) << "so that the test can fail";
  }
}

TEST(UprightPicture, SrgbsOwnProfileChangesNoBit) {
  auto bytes = encoded(blocks(), ".png");
  ASSERT_TRUE(write_file(seen_folder() / "plain.png", bytes));
  ASSERT_TRUE(
      write_file(seen_folder() / "srgb.png", with_chunk(bytes, "iCCP", iccp(profile_bytes(cmsCreate_sRGBProfile())))));
  EXPECT_EQ(read_photograph(seen_folder() / "plain.png").value().encoded.elements(),
            read_photograph(seen_folder() / "srgb.png").value().encoded.elements());
}

TEST(UprightPicture, WhatCannotBeAppliedIsRefusedInWords) {
  const auto refusal = [](const SeenBytes& profile) {
    EXPECT_TRUE(
        write_file(seen_folder() / "refused.png", with_chunk(encoded(blocks(), ".png"), "iCCP", iccp(profile))));
    const auto read = read_photograph(seen_folder() / "refused.png");
    return read ? std::string() : read.error().message;
  };
  EXPECT_THAT(refusal(SeenBytes(500, 7)), HasSubstr("damaged: expected it saved as sRGB"));
  EXPECT_THAT(refusal(profile_bytes(cmsCreateInkLimitingDeviceLink(cmsSigCmykData, 200.0))), HasSubstr("four inks"));
  // 6 MB of nothing in some kilobytes.
  EXPECT_THAT(refusal(SeenBytes(6 << 20, 0)), HasSubstr("more than"));
}

// A camera's: when, where, and a thumbnail.
SeenBytes camera_exif() {
  SeenBytes e;
  const auto entry = [&](std::uint32_t tag, std::uint32_t type, std::uint32_t count, std::uint32_t value) {
    append_big(e, tag, 2), append_big(e, type, 2), append_big(e, count, 4), append_big(e, value, 4);
  };
  append(e, "MM\0*\0\0\0\x08", 8);
  append_big(e, 4, 2);
  entry(0x010f, 2, 4, 0x4d616b00);  // Make "Mak"
  entry(0x0112, 3, 1, 0x00010000);
  entry(0x8769, 4, 1, 62);   // Exif
  entry(0x8825, 4, 1, 120);  // GPS
  append_big(e, 0, 4);       // at 58
  append_big(e, 2, 2);       // at 62
  entry(0x9003, 2, 20, 92);  // DateTimeOriginal
  entry(0x9011, 2, 7, 112);  // OffsetTimeOriginal
  append_big(e, 0, 4);       // at 88
  append(e, "2019:06:21 12:34:56\0", 20);
  append(e, "+02:00\0\0", 8);
  append_big(e, 2, 2);              // at 120
  entry(0x0001, 2, 2, 0x4e000000);  // north
  entry(0x0002, 5, 3, 150);
  append_big(e, 0, 4);  // at 146
  for (const std::uint32_t n : {47u, 1u, 30u, 1u, 15u, 1u}) append_big(e, n, 4);
  append(e, "THUMBNAIL", 9);
  return e;
}

TEST(UprightPicture, WhatIsWrittenSaysSrgbWhenAndWhereAndNoMore) {
  ASSERT_TRUE(write_file(seen_folder() / "taken.jpg",
                         with_segment(encoded(blocks(), ".jpg"), 0xe1, headed("Exif\0\0", 6, camera_exif()))));
  const auto taken = read_photograph(seen_folder() / "taken.jpg").value();
  for (const char* name : {"made.png", "made.jpg", "made.tiff"}) {
    ASSERT_TRUE(write_photograph(seen_folder() / name, taken));
    const auto bytes = read_file(seen_folder() / name).value();
    const std::string text(bytes.begin(), bytes.end());
    EXPECT_THAT(text, HasSubstr("2019:06:21 12:34:56")) << name;
    for (const char* word : {"THUMBNAIL", "Mak"}) EXPECT_THAT(text, testing::Not(HasSubstr(word))) << name;
    EXPECT_EQ(text.find("sRGB") != std::string::npos, std::string(name) == "made.png")
        << "a JPEG says it in EXIF, a TIFF by its profile";
    const auto tags = embedded_tags(*picture_header(bytes), bytes).value();
    const std::string exif(tags.exif.begin(), tags.exif.end());
    EXPECT_NE(exif.find(std::string("\x01\xa0\x03\0\x01\0\0\0\x01\0", 10)), std::string::npos) << "ColorSpace sRGB";
    const std::string place("\x2f\0\0\0\1\0\0\0\x1e\0\0\0\1\0\0\0\x0f\0\0\0\1\0\0\0", 24);  // 47/1 30/1 15/1
    EXPECT_THAT(exif, HasSubstr(place)) << name;
    EXPECT_TRUE(read_photograph(seen_folder() / name)) << "and is a picture";
  }
  const auto when = picture_time(seen_folder() / "made.jpg", {});
  ASSERT_TRUE(when);
  EXPECT_EQ(when, picture_time(seen_folder() / "taken.jpg", {}));
  // Nothing is made up.
  auto plain = taken;
  plain.origin.clear();
  ASSERT_TRUE(write_photograph(seen_folder() / "plain.png", plain));
  EXPECT_THAT(read_text_file(seen_folder() / "plain.png").value(), testing::Not(HasSubstr("eXIf")));
}

Result<cv::Mat> mask_from(const cv::Mat& rgba) {
  return mask_of({rgba, 1.0 / 255.0, false, {}});
}

TEST(UprightPicture, AMaskPaintedAsTransparencyIsAMask) {
  cv::Mat photograph(4, 4, CV_8UC4);
  cv::randu(photograph, 0, 255);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 4; ++x) photograph.at<cv::Vec4b>(y, x)[3] = x < 2 ? 255 : x == 2 ? 100 : 0;
  const auto erased = must(mask_from(photograph));
  EXPECT_EQ(erased->at<std::uint8_t>(1, 0), 255);
  EXPECT_EQ(erased->at<std::uint8_t>(1, 2), 100);
  EXPECT_EQ(erased->at<std::uint8_t>(1, 3), 0);
  // White and black ink, and some of it cut out.
  cv::Mat inked(1, 3, CV_8UC4);
  inked.at<cv::Vec4b>(0, 0) = {255, 255, 255, 255};
  inked.at<cv::Vec4b>(0, 1) = {0, 0, 0, 255};
  inked.at<cv::Vec4b>(0, 2) = {255, 255, 255, 0};
  EXPECT_EQ(cv::norm(mask_from(inked).value(), cv::Mat((cv::Mat_<std::uint8_t>(1, 3) << 255, 0, 0)), cv::NORM_INF),
            0.0);
  // Opaque: as without alpha.
  cv::Mat opaque(1, 2, CV_8UC4, cv::Scalar(50, 50, 50, 255));
  EXPECT_EQ(mask_from(opaque).value().at<std::uint8_t>(0, 1), 50);
  cv::Mat black(1, 2, CV_8UC4, cv::Scalar(0, 0, 0, 255));
  black.at<cv::Vec4b>(0, 0) = {0, 0, 0, 0};
  EXPECT_THAT(mask_from(black).error().message, HasSubstr("either may be meant"));
}

}  // namespace
}  // namespace kasumi
