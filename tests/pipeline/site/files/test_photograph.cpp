#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iostream>

#include <opencv2/imgcodecs.hpp>

#include "base/files.hpp"
#include "base/picture_files/embedded_tags.hpp"
#include "base/picture_files/rare_files.hpp"
#include "pipeline/site/config/content.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/places.hpp"
#include "tests/small_disk.hpp"

namespace kasumi {
namespace {

std::filesystem::path folder() {
  const auto path = test_output_folder() / "photograph";
  std::filesystem::create_directories(path);
  return path;
}

TEST(Photograph, EightBitsComeBackExactlyAndInTheRightChannelOrder) {
  Image<Rgb8> picture(3, 2, Rgb8(200, 100, 50));
  picture.at(2, 1) = Rgb8(1, 2, 3);
  ASSERT_TRUE(write_png(folder() / "a.png", picture));
  const auto photograph = read_photograph(folder() / "a.png");
  ASSERT_TRUE(photograph);
  EXPECT_DOUBLE_EQ(photograph->quantum, 1.0 / 255.0);
  EXPECT_EQ(to_rgb8(*photograph).elements(), picture.elements());
}

// 25 kB that take three gigabytes when they are read.
TEST(Photograph, APictureOfTooManyPixelsIsRefusedBeforeItIsDecoded) {
  const auto file = folder() / "huge.png";
  ASSERT_TRUE(cv::imwrite(file.string(), cv::Mat(14000, 14000, CV_8UC1, cv::Scalar(0)), {cv::IMWRITE_PNG_BILEVEL, 1}));
  const auto refused = read_photograph(file);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::bad_input);
  EXPECT_EQ(refused.error().message,
            file.string() + ": a PNG of 14000 x 14000 pixels: expected 1 .. 32768 each way and 160 million at most");
}

// Whatever the format, half a file is no picture, and no library writes its own words about it; of a JPEG what is left may
// be asked for.
TEST(Photograph, HalfAFileIsRefused) {
  cv::Mat noise(240, 320, CV_8UC3);
  cv::randu(noise, 0, 255);
  for (const std::string ending : {".jpg", ".png", ".tif", ".ppm", ".bmp"}) {
    const auto whole = folder() / ("whole" + ending), half = folder() / ("half" + ending);
    ASSERT_TRUE(cv::imwrite(whole.string(), noise));
    ASSERT_TRUE(read_photograph(whole)) << ending;
    std::filesystem::copy_file(whole, half, std::filesystem::copy_options::overwrite_existing);
    std::filesystem::resize_file(half, std::filesystem::file_size(whole) / 2);
    testing::internal::CaptureStderr();
    const auto read = read_photograph(half);
    std::cerr << "still heard";
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "still heard") << ending;
    ASSERT_FALSE(read) << ending;
    EXPECT_EQ(read.error().kind, FaultKind::bad_input) << ending;
    EXPECT_THAT(read.error().message, testing::HasSubstr(half.filename().string()));
  }
  std::string damage;
  const auto rest = read_photograph(folder() / "half.jpg", &damage);
  ASSERT_TRUE(rest) << rest.error().message;
  EXPECT_THAT(damage, testing::HasSubstr("of 240 rows are whole"));
  EXPECT_TRUE(read_still(folder() / "half.jpg")) << "half a still picture is better than a black screen";
  ASSERT_TRUE(read_photograph(folder() / "whole.jpg", &damage));
  EXPECT_EQ(damage, "");
}

TEST(Photograph, SixteenBitsKeepTheirDigits) {
  cv::Mat image(1, 1, CV_16UC3, cv::Scalar(1000, 30000, 65535));  // B G R
  ASSERT_TRUE(cv::imwrite((folder() / "b.png").string(), image));
  const auto photograph = read_photograph(folder() / "b.png").value();
  EXPECT_DOUBLE_EQ(photograph.quantum, 1.0 / 65535.0);
  EXPECT_NEAR(photograph.encoded.at(0, 0).r, 1.0, 1e-6);
  EXPECT_NEAR(photograph.encoded.at(0, 0).b, 1000.0 / 65535.0, 1e-7);
}

// The profile is looked for by the program's reader of tags, and whether it is sRGB's by lcms2, which then has nothing to
// change; OpenCV, as any other reader, sees the same picture in one page.
TEST(Photograph, ATiffBringsTheProfileOfSrgb) {
  for (const bool fine : {false, true}) {
    const auto file = folder() / "profile.tiff";
    Photograph photograph;
    photograph.quantum = fine ? 1.0 / 65535.0 : 1.0 / 255.0;
    photograph.encoded = Image<glm::vec3>(31, 17);
    for (int y = 0; y < 17; ++y)
      for (int x = 0; x < 31; ++x)
        photograph.encoded.at(x, y) = {static_cast<float>(x) / 30.0F, static_cast<float>(y) / 16.0F, 0.2F};
    ASSERT_TRUE(write_photograph(file, photograph));
    const auto bytes = read_file(file).value();
    const auto tags = embedded_tags(picture_header(bytes).value(), bytes);
    ASSERT_TRUE(tags) << tags.error().message;
    ASSERT_GT(tags->profile.size(), 128u);
    EXPECT_EQ(std::string(tags->profile.begin() + 36, tags->profile.begin() + 40), "acsp");
    cv::Mat picture(1, 3, CV_8UC3, cv::Scalar(200, 100, 50));
    const auto wrong = rare_files().value()->to_srgb(picture, tags->profile);
    EXPECT_EQ(wrong, "");
    EXPECT_EQ(picture.depth(), CV_8U) << "it is another profile than sRGB's";
    std::vector<cv::Mat> pages;
    ASSERT_TRUE(cv::imreadmulti(file.string(), pages, cv::IMREAD_UNCHANGED));
    ASSERT_EQ(pages.size(), 1u);
    EXPECT_EQ(pages[0].depth(), fine ? CV_16U : CV_8U);
    const auto again = read_photograph(file);
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_DOUBLE_EQ(again->quantum, photograph.quantum);
    for (int x = 0; x < 31; ++x)
      EXPECT_NEAR(again->encoded.at(x, 5).r, photograph.encoded.at(x, 5).r, 0.5 * photograph.quantum + 1e-6);
    ASSERT_TRUE(write_photograph(file, photograph));
    EXPECT_EQ(read_file(file).value(), bytes) << "the same bytes every time";
  }
}

TEST(Photograph, GreyAndAlphaAreBroughtToThreeChannels) {
  ASSERT_TRUE(cv::imwrite((folder() / "grey.png").string(), cv::Mat(2, 2, CV_8UC1, cv::Scalar(51))));
  ASSERT_TRUE(cv::imwrite((folder() / "alpha.png").string(), cv::Mat(2, 2, CV_8UC4, cv::Scalar(10, 20, 30, 40))));
  EXPECT_EQ(to_rgb8(read_photograph(folder() / "grey.png").value()).at(1, 1), Rgb8(51));
  EXPECT_EQ(to_rgb8(read_photograph(folder() / "alpha.png").value()).at(1, 1), Rgb8(30, 20, 10));
}

TEST(Photograph, AnInvalidPictureIsNamedInTheMessage) {
  std::ofstream(folder() / "c.png") << "this is text";
  std::ofstream(folder() / "empty.png").close();
  ASSERT_TRUE(write_png(folder() / "whole.png", Image<Rgb8>(64, 64, Rgb8(7))));
  for (const char* name : {"c.png", "empty.png", "missing.png"}) {
    const auto result = read_photograph(folder() / name);
    ASSERT_FALSE(result) << name;
    EXPECT_EQ(result.error().kind, FaultKind::bad_input);
    EXPECT_THAT(result.error().message, testing::HasSubstr(name));
  }
}

TEST(PictureSink, OnlyAnEarlierRunsPicturesAreRemovedFromAFolder) {
  const auto out = folder() / "sink";
  std::filesystem::create_directories(out);
  std::ofstream(out / "frame-000007.png") << "old";
  std::ofstream(out / "notes.txt") << "mine";
  auto sink = open_picture_folder(out).value();
  ASSERT_TRUE(sink->put(Image<Rgb8>(4, 4, Rgb8(9))));
  ASSERT_TRUE(sink->finish());
  EXPECT_TRUE(std::filesystem::exists(out / "frame-000000.png"));
  EXPECT_FALSE(std::filesystem::exists(out / "frame-000007.png"));
  EXPECT_TRUE(std::filesystem::exists(out / "notes.txt"));
}

TEST(PictureSink, AFilmAppearsUnderItsNameOnlyWhenComplete) {
  const auto file = folder() / "film.mp4";
  std::filesystem::remove(file);
  auto film = open_film(file, 10.0).value();
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(film->put(Image<Rgb8>(64, 48, Rgb8(static_cast<std::uint8_t>(40 * i)))));
  EXPECT_FALSE(std::filesystem::exists(file));
  const auto finished = film->finish();
  ASSERT_TRUE(finished) << finished.error().message;
  EXPECT_GT(std::filesystem::file_size(file), 200u);
}

TEST(PictureSink, AFilmsNameMayHoldAColon) {
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder());
  auto film = open_film("10:30.mp4", 10.0).value();
  const auto put = film->put(Image<Rgb8>(64, 48, Rgb8(40)));
  const auto finished = film->finish();
  const bool exists = std::filesystem::exists("10:30.mp4");
  std::filesystem::current_path(before);
  EXPECT_TRUE(put) << put.error().message;
  EXPECT_TRUE(finished) << finished.error().message;
  EXPECT_TRUE(exists);
}

TEST(PictureSink, AFilmHasAllItsPicturesInTheirColoursAndOrder) {
  const auto file = folder() / "colours.mp4";
  const std::array<Rgb8, 3> colours{Rgb8(200, 60, 40), Rgb8(50, 160, 60), Rgb8(40, 70, 190)};
  auto film = open_film(file, 25.0).value();
  for (int i = 0; i < 60; ++i) ASSERT_TRUE(film->put(Image<Rgb8>(65, 49, colours[static_cast<std::size_t>(i / 20)])));
  ASSERT_TRUE(film->finish());
  const auto decoder = rare_files().value()->open_film(file.string());
  ASSERT_TRUE(decoder);
  EXPECT_NEAR(decoder->frames_per_second(), 25.0, 1e-3);
  cv::Mat bgr;
  int pictures = 0;
  for (; decoder->read(bgr); ++pictures) {
    ASSERT_EQ(bgr.size(), cv::Size(64, 48)) << "even, as the codecs need them";
    const auto seen = bgr.at<cv::Vec3b>(24, 32);
    const auto& given = colours[static_cast<std::size_t>(std::min(pictures / 20, 2))];
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[2 - c], given[c], 4) << pictures;
  }
  EXPECT_EQ(pictures, 60);
}

TEST(PictureSink, AFilmForWhichTheDiskHasNoRoomIsReportedAndRemoved) {
  const auto out = folder() / "no-room";
  std::filesystem::remove_all(out);
  Image<Rgb8> noise(320, 240);
  std::uint32_t state = 1;
  {
    auto film = open_film(out / "film.mp4", 10.0).value();
    const SmallDisk disk(20'000);
    Result<> written;
    for (int i = 0; i < 60 && written; ++i) {
      for (auto& pixel : noise.elements())
        pixel = Rgb8(static_cast<std::uint8_t>((state = 1664525u * state + 1u) >> 24));
      written = film->put(noise);
    }
    if (written) written = film->finish();
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().kind, FaultKind::io);
    EXPECT_THAT(written.error().message, testing::HasSubstr((out / "film.mp4").string() + ": writing failed: "));
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(out), {}), 0);
}

TEST(PictureSink, AnAbandonedFilmLeavesNothingBehind) {
  const auto out = folder() / "abandoned";
  std::filesystem::remove_all(out);
  { ASSERT_TRUE(open_film(out / "film.mp4", 10.0).value()->put(Image<Rgb8>(64, 48))); }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(out), {}), 0);
}

}  // namespace
}  // namespace kasumi
