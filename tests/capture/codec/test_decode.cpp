#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/capture/known_frames.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

// Studio range BT.601, as published with every video card: red, green, blue are
constexpr std::uint8_t kRedY = 81, kRedU = 90, kRedV = 240;
constexpr std::uint8_t kBlueY = 41, kBlueU = 240, kBlueV = 110;

void expect_near(const Rgb8& pixel, const Rgb8& expected, int tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(pixel[c], expected[c], tolerance) << "channel " << c;
}

Rgb8 pixel_of(const Frame& frame, int x, int y, YuvEncoding encoding = YuvEncoding::bt601_limited) {
  const auto picture = decode(frame, encoding);
  EXPECT_TRUE(picture) << picture.error().message;
  return picture ? rgb_at(picture->view(), x, y) : Rgb8{};
}

TEST(Decode, EachRgbFormatPutsItsBytesIntoTheRightChannels) {
  const std::vector<std::pair<const char*, std::vector<std::uint8_t>>> formats{
      {"RGB3", {1, 2, 3, 4, 5, 6}},
      {"BGR3", {3, 2, 1, 6, 5, 4}},
      {"XR24", {3, 2, 1, 99, 6, 5, 4, 99}},
      {"AB24", {1, 2, 3, 99, 4, 5, 6, 99}},
  };
  for (const auto& [code, bytes] : formats) {
    const auto frame = frame_with(parse_four_cc(code).value(), 2, 1, static_cast<std::uint32_t>(bytes.size()), bytes);
    EXPECT_EQ(pixel_of(frame, 0, 0), Rgb8(1, 2, 3)) << code;
    EXPECT_EQ(pixel_of(frame, 1, 0), Rgb8(4, 5, 6)) << code;
  }
  EXPECT_EQ(pixel_of(frame_with(four_cc("GREY"), 2, 1, 2, {7, 9}), 1, 0), Rgb8(9));
}

TEST(Decode, PackedYuvSharesItsChromaBetweenTwoPixels) {
  const auto yuyv = frame_with(four_cc("YUYV"), 4, 1, 8, {kRedY, kRedU, 16, kRedV, kBlueY, kBlueU, kBlueY, kBlueV});
  expect_near(pixel_of(yuyv, 0, 0), {255, 0, 0}, 1);
  EXPECT_LT(pixel_of(yuyv, 1, 0).x, 200) << "a darker pixel with the same chroma";
  expect_near(pixel_of(yuyv, 3, 0), {0, 0, 255}, 1);
  const auto uyvy = frame_with(four_cc("UYVY"), 4, 1, 8, {kRedU, kRedY, kRedV, 16, kBlueU, kBlueY, kBlueV, kBlueY});
  for (int x = 0; x < 4; ++x) EXPECT_EQ(pixel_of(uyvy, x, 0), pixel_of(yuyv, x, 0));
}

TEST(Decode, PlanarYuvFindsItsPlanesAfterPaddedRows) {
  // 4x2 pixels, the left half red, the right half blue; rows are padded to 6 bytes.
  const std::vector<std::uint8_t> luma{kRedY, kRedY, kBlueY, kBlueY, 0, 0, kRedY, kRedY, kBlueY, kBlueY, 0, 0};
  auto nv12 = luma;
  nv12.insert(nv12.end(), {kRedU, kRedV, kBlueU, kBlueV});
  auto yu12 = luma;
  yu12.insert(yu12.end(), {kRedU, kBlueU, 0, kRedV, kBlueV});
  for (const auto& frame : {frame_with(four_cc("NV12"), 4, 2, 6, nv12), frame_with(four_cc("YU12"), 4, 2, 6, yu12)})
    for (int y = 0; y < 2; ++y) {
      expect_near(pixel_of(frame, 1, y), {255, 0, 0}, 1);
      expect_near(pixel_of(frame, 2, y), {0, 0, 255}, 1);
    }
}

TEST(Decode, TheEncodingSaysWhatYuvMeans) {
  const auto frame = frame_with(four_cc("YUYV"), 2, 1, 4, {63, 102, 63, 240});  // red in studio range BT.709
  expect_near(pixel_of(frame, 0, 0, YuvEncoding::bt709_limited), {255, 0, 0}, 1);
  EXPECT_GT(pixel_of(frame, 0, 0, YuvEncoding::bt601_full).x, 200);
  EXPECT_GT(pixel_of(frame, 0, 0, YuvEncoding::bt601_full).z, 10);
}

TEST(Decode, APictureOutlivesItsFrame) {
  auto frame = std::make_unique<Frame>(frame_with(four_cc("GREY"), 2, 1, 2, {7, 9}));
  const auto picture = decode(*frame, YuvEncoding::bt601_full).value();
  frame.reset();
  EXPECT_EQ(rgb_at(picture.view(), 1, 0), Rgb8(9));
}

TEST(Decode, APayloadOneByteShortIsRefusedForEveryUncompressedFormat) {
  for (const char* code : {"YUYV", "UYVY", "NV12", "YU12", "RGB3", "BGR3", "XR24", "AB24", "GREY"})
    for (const std::uint32_t padding : {0u, 5u}) {
      const auto format = parse_four_cc(code).value();
      const auto row = plane_size(*layout_of(format), 5, 3, 0).row_bytes;
      const auto whole =
          encode_frame(test_picture(5, 3), format, {.stride = static_cast<std::uint32_t>(row) + padding});
      ASSERT_TRUE(whole);
      ASSERT_TRUE(decode(*whole, YuvEncoding::bt601_full)) << code;
      EXPECT_EQ(judge(whole->metadata, whole->payload.bytes.size(), false), FrameStatus::good);
      EXPECT_EQ(judge(whole->metadata, whole->payload.bytes.size() - 1, false), FrameStatus::truncated);

      auto bytes = std::vector<std::uint8_t>(whole->payload.bytes.begin(), whole->payload.bytes.end());
      bytes.pop_back();
      const auto cut = frame_with(format, 5, 3, whole->metadata.stride, bytes);
      const auto refused = decode(cut, YuvEncoding::bt601_full);
      ASSERT_FALSE(refused) << code;
      EXPECT_THAT(refused.error().message, HasSubstr("expected at least"));
      EXPECT_EQ(judge(cut.metadata, bytes.size(), false), FrameStatus::truncated);

      auto short_use = *whole;  // the buffer is long enough, but the driver filled only part of it
      short_use.metadata.bytes_used -= 1;
      EXPECT_FALSE(decode(short_use, YuvEncoding::bt601_full)) << code;
    }
}

TEST(Decode, BadFramesAreRefusedByName) {
  auto frame = frame_with(four_cc("GREY"), 2, 1, 2, {7, 9});
  frame.metadata.status = FrameStatus::flagged;
  EXPECT_THAT(decode(frame, YuvEncoding::bt601_full).error().message, HasSubstr("flagged"));
  frame.metadata.status = FrameStatus::truncated;
  EXPECT_THAT(decode(frame, YuvEncoding::bt601_full).error().message, HasSubstr("truncated"));
}

TEST(Decode, AnEmptyPayloadIsTruncatedInEveryFormat) {
  for (const char* code : {"MJPG", "YUYV", "NV12", "RGB3"}) {
    const auto frame = frame_with(parse_four_cc(code).value(), 2, 2, 8, {});
    EXPECT_EQ(judge(frame.metadata, 0, false), FrameStatus::truncated) << code;
    EXPECT_EQ(judge(frame.metadata, 0, true), FrameStatus::flagged) << code;
    EXPECT_FALSE(decode(frame, YuvEncoding::bt601_full)) << code;
  }
}

TEST(Decode, ImpossibleSizesAreAllReportedAtOnce) {
  FrameMetadata metadata;
  metadata.format = four_cc("XXXX");
  metadata.width = 1 << 30;
  metadata.height = -1;
  metadata.stride = 0xFFFFFFFF;
  metadata.bytes_used = 0xFFFFFFFF;
  const auto message = check_geometry(metadata).error().message;
  EXPECT_THAT(message, HasSubstr("\"XXXX\": expected one of MJPG, YUYV"));
  EXPECT_THAT(message, HasSubstr("size 1073741824x-1: expected 1 to 16384"));
  EXPECT_THAT(message, HasSubstr("stride 4294967295: expected at most"));
  EXPECT_THAT(message, HasSubstr("bytes_used 4294967295: expected at most"));
}

TEST(Decode, SizesWhoseProductsOverflowAreRefused) {
  for (const auto& [width, height] : {std::pair{65536, 65536}, std::pair{16384, 16384}, std::pair{0, 8}}) {
    const auto frame = frame_with(four_cc("RGB3"), width, height, 65536u * 3, std::vector<std::uint8_t>(64));
    EXPECT_THAT(decode(frame, YuvEncoding::bt601_full).error().message, HasSubstr("size")) << width;
  }
  const auto frame = frame_with(four_cc("RGB3"), 4, 2, 11, std::vector<std::uint8_t>(64));
  EXPECT_THAT(decode(frame, YuvEncoding::bt601_full).error().message,
              HasSubstr("stride 11: expected at least 12 bytes for a row of 4 pixels RGB3"));
}

TEST(Encode, PrimariesBecomeTheirPublishedYuv) {
  const Image<Rgb8> red(2, 2, {255, 0, 0}), white(2, 2, {255, 255, 255}), blue(2, 2, {0, 0, 255});
  const auto bytes = [](const Image<Rgb8>& image, YuvEncoding encoding) {
    const auto frame = encode_frame(image, four_cc("NV12"), {.yuv_encoding = encoding}).value();
    return std::vector<std::uint8_t>(frame.payload.bytes.begin(), frame.payload.bytes.end());
  };
  using Bytes = std::vector<std::uint8_t>;
  EXPECT_EQ(bytes(red, YuvEncoding::bt601_limited), Bytes({81, 81, 81, 81, 90, 240}));
  EXPECT_EQ(bytes(blue, YuvEncoding::bt601_limited), Bytes({41, 41, 41, 41, 240, 110}));
  EXPECT_EQ(bytes(red, YuvEncoding::bt709_limited), Bytes({63, 63, 63, 63, 102, 240}));
  EXPECT_EQ(bytes(white, YuvEncoding::bt601_limited), Bytes({235, 235, 235, 235, 128, 128}));
  EXPECT_EQ(bytes(white, YuvEncoding::bt601_full), Bytes({255, 255, 255, 255, 128, 128}));
  EXPECT_EQ(bytes(red, YuvEncoding::bt601_full), Bytes({76, 76, 76, 76, 85, 255}));  // JFIF
}

TEST(Encode, ChromaIsTheMeanOfThePixelsThatShareIt) {
  Image<Rgb8> image(2, 2, {128, 128, 128});
  image.at(0, 0) = {0, 0, 255};  // U of blue is 255 (.5 up), of grey 128, in full range
  const auto frame = encode_frame(image, four_cc("YU12")).value();
  EXPECT_NEAR(frame.payload.bytes[4], 128 + 127.5 / 4, 0.51);
}

TEST(Encode, EveryUncompressedFormatRoundTripsASmoothPicture) {
  const auto image = test_picture(37, 23);
  for (const char* code : {"YUYV", "UYVY", "NV12", "YU12", "RGB3", "BGR3", "XR24", "AB24"})
    for (const auto encoding : {YuvEncoding::bt601_full, YuvEncoding::bt709_limited}) {
      const auto frame =
          must(encode_frame(image, parse_four_cc(code).value(), {.yuv_encoding = encoding, .stride = 160}));
      const auto picture = must(decode(*frame, encoding));
      for (int y = 0; y < image.height(); ++y)
        for (int x = 0; x < image.width(); ++x) expect_near(rgb_at(picture->view(), x, y), image.at(x, y), 3);
    }
}

TEST(Encode, AStrideShorterThanARowIsRefused) {
  EXPECT_THAT(encode_frame(test_picture(8, 6), four_cc("YUYV"), {.stride = 15}),
              FailsWith(HasSubstr("stride 15: expected at least 16")));
}

}  // namespace
}  // namespace kasumi
