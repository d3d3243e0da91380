// Depth maps, written byte by byte or by OpenCV's PNG writer.
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "base/files.hpp"
#include "calib/distances/distance_map.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

constexpr int kWidth = 5, kHeight = 3;

fs::path folder() {
  const auto path = test_output_folder() / "distance-map";
  fs::create_directories(path);
  return path;
}

struct Read {
  Image<float> map;
  std::string problems;
};
Read read(const std::string& keys, int width = kWidth) {
  const auto root = ConfigTable::parse("[scene]\n" + keys, folder() / "kasumi.toml").value();
  auto map = read_distance_map(root.table("scene"), width, kHeight);
  const auto finished = root.finish();
  return {std::move(map), finished ? "" : finished.error().message};
}

std::uint16_t steps_at(int x, int y) {
  return static_cast<std::uint16_t>(x == 0 ? 0 : 10000 * x + 300 * y);
}

void write_png(const char* name, int type) {
  cv::Mat map(kHeight, kWidth, type);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      if (type == CV_16UC1)
        map.at<std::uint16_t>(y, x) = steps_at(x, y);
      else
        map.at<std::uint8_t>(y, x) = 7;
  cv::imwrite((folder() / name).string(), map);
}

// Portable float map: rows from the bottom upwards; a negative scale says little endian.
template <class Value>
void write_pfm(const char* name, Value value) {
  const std::string head = fmt::format("Pf\n{} {}\n-1.0\n", kWidth, kHeight);
  std::vector<std::uint8_t> bytes(head.begin(), head.end());
  for (int y = kHeight - 1; y >= 0; --y)
    for (int x = 0; x < kWidth; ++x) {
      const float metres = value(x, y);
      std::uint32_t bits = 0;
      std::memcpy(&bits, &metres, sizeof bits);
      for (int byte = 0; byte < 4; ++byte) bytes.push_back(static_cast<std::uint8_t>(bits >> (8 * byte)));
    }
  ASSERT_TRUE(write_file(folder() / name, bytes));
}

TEST(DistanceMap, WithoutTheKeyThereIsNone) {
  const auto [map, problems] = read("");
  EXPECT_TRUE(map.empty());
  EXPECT_EQ(problems, "");
}

TEST(DistanceMap, APngHoldsSixteenBitsOfSteps) {
  write_png("depth.png", CV_16UC1);
  const auto [map, problems] = read("depth_map = 'depth.png'\ndepth_step_m = 0.25\n");
  ASSERT_EQ(problems, "");
  ASSERT_EQ(map.width(), kWidth);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) EXPECT_FLOAT_EQ(map.at(x, y), 0.25f * steps_at(x, y)) << x << ", " << y;
}

TEST(DistanceMap, AFloatMapHoldsMetresAndInfinityIsSky) {
  write_pfm("depth.pfm", [](int x, int y) {
    return x == 4 ? std::numeric_limits<float>::infinity() : 1234.5f + 10.0f * float(x) + 0.25f * float(y);
  });
  const auto [map, problems] = read("depth_map = 'depth.pfm'\n");
  ASSERT_EQ(problems, "");
  EXPECT_EQ(map.at(0, 0), 1234.5f);
  EXPECT_EQ(map.at(3, 2), 1265.0f);
  EXPECT_EQ(map.at(4, 1), 0.0f);
}

TEST(DistanceMap, ProblemsOfTheFileAreReported) {
  write_png("depth.png", CV_16UC1);
  write_png("eight-bits.png", CV_8UC1);
  ASSERT_TRUE(write_text_file(folder() / "words.png", "not a picture"));
  ASSERT_TRUE(write_text_file(folder() / "nothing.png", ""));
  const std::string step = "depth_step_m = 1\n";
  EXPECT_THAT(read("depth_map = 'depth.png'\n" + step, 6).problems, HasSubstr("6 x 3 (it is 5 x 3)"));
  EXPECT_THAT(read("depth_map = 'eight-bits.png'\n" + step).problems, HasSubstr("PNG of 16 bits"));
  EXPECT_THAT(read("depth_map = 'words.png'\n" + step).problems, HasSubstr("expected a depth map: a grey PNG"));
  ASSERT_TRUE(write_text_file(folder() / "array.npy", "\x93NUMPY\1"));
  EXPECT_THAT(read("depth_map = 'array.npy'\n" + step).problems,
              testing::AllOf(HasSubstr("an array of NumPy"), HasSubstr("cv2.imwrite('OUT.tiff'")));
  EXPECT_THAT(read("depth_map = 'nothing.png'\n" + step).problems, HasSubstr("expected a depth map: a grey PNG"));
  EXPECT_THAT(read("depth_map = 'absent.png'\n" + step).problems,
              HasSubstr("scene.depth_map = 'absent.png': expected an existing file"));
  EXPECT_THAT(read("depth_map = 'depth.png'\n").problems, HasSubstr("scene.depth_step_m is missing"));
  EXPECT_THAT(read("depth_map = 'depth.png'\ndepth_step_m = 0\n").problems, HasSubstr("scene.depth_step_m = 0"));
  EXPECT_THAT(read(step).problems, HasSubstr("scene.depth_step_m = 1"));
}

TEST(DistanceMap, NegativeDistancesAreReportedWithTheirPosition) {
  write_pfm("negative.pfm", [](int x, int y) { return x == 2 && y == 1 ? -3.5f : 100.0f; });
  EXPECT_THAT(read("depth_map = 'negative.pfm'\n").problems,
              testing::AllOf(HasSubstr("pixel 2, 1 is -3.5"), HasSubstr("--no-data, depth_no_data")));
  const auto [map, problems] = read("depth_map = 'negative.pfm'\ndepth_no_data = -3.5\n");
  EXPECT_EQ(problems, "");
  EXPECT_EQ(map.at(2, 1), 0.0f) << "a fifteenth of the picture is a large hole: sky";
}

// ---- what numbers mean

constexpr int kWide = 60, kHigh = 40, kHorizon = 16;
constexpr float kSky = std::numeric_limits<float>::infinity();
float land_m(int y) {
  return 2000.0f / static_cast<float>(y - kHorizon + 1);
}

fs::path pfm_of(const char* name, const Image<float>& values, const char* scale = "-1.0") {
  const std::string head = fmt::format("Pf\n{} {}\n{}\n", values.width(), values.height(), scale);
  std::vector<std::uint8_t> bytes(head.begin(), head.end());
  for (int y = values.height() - 1; y >= 0; --y)
    for (int x = 0; x < values.width(); ++x) {
      std::uint32_t bits = 0;
      std::memcpy(&bits, &values.at(x, y), sizeof bits);
      for (int byte = 0; byte < 4; ++byte)
        bytes.push_back(static_cast<std::uint8_t>(bits >> (8 * (scale[0] == '-' ? byte : 3 - byte))));
    }
  EXPECT_TRUE(write_file(folder() / name, bytes));
  return folder() / name;
}
Image<float> landscape(float sky, float scale = 1.0f) {
  Image<float> map(kWide, kHigh);
  for (int y = 0; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x) map.at(x, y) = y < kHorizon ? sky : scale * land_m(y);
  return map;
}
void expect_landscape(const Result<DistanceMap>& map, float sky, double share_known = 0.6) {
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_NEAR(map->known, share_known, 1e-6) << map->summary();
  for (int y = 0; y < kHigh; ++y) {
    const float wanted = y < kHorizon ? sky : land_m(y);
    if (std::isfinite(wanted))
      EXPECT_NEAR(map->metres.at(7, y), wanted, 0.2) << y;
    else
      EXPECT_EQ(map->metres.at(7, y), wanted) << y;
  }
}

TEST(DistanceNumbers, BackgroundsAreSkyAndWhatHoldsNothingIsNotKnown) {
  for (const float background : {kSky, 1e10f, 3.4e38f, 65504.0f})
    expect_landscape(read_distances(pfm_of("sky.pfm", landscape(background)), {}, kWide, kHigh), kSky);
  for (const float nothing : {0.0f, std::numeric_limits<float>::quiet_NaN()})
    expect_landscape(read_distances(pfm_of("none.pfm", landscape(nothing)), {}, kWide, kHigh), 0.0f);
  DistanceFile file;
  file.zero_is_sky = true;
  expect_landscape(read_distances(pfm_of("zero.pfm", landscape(0.0f)), file, kWide, kHigh), kSky);
  file.no_data = -1.0;
  expect_landscape(read_distances(pfm_of("minus.pfm", landscape(-1.0f)), file, kWide, kHigh), 0.0f);
  file.sky_beyond_m = 5000.0;
  expect_landscape(read_distances(pfm_of("far.pfm", landscape(6000.0f)), file, kWide, kHigh), kSky);
}

TEST(DistanceNumbers, APfmsScaleIsAnOrderOfBytesAndAStepIsTheUnit) {
  for (const char* scale : {"-1.0", "1.0", "-0.001", "0.003922"})
    expect_landscape(read_distances(pfm_of("scale.pfm", landscape(0.0f), scale), {}, kWide, kHigh), 0.0f);
  DistanceFile millimetres;
  millimetres.scale = 0.001;
  expect_landscape(read_distances(pfm_of("mm.pfm", landscape(0.0f, 1000.0f)), millimetres, kWide, kHigh), 0.0f);
}

TEST(DistanceNumbers, SixteenBitsThatAreFullHoldNothing) {
  cv::Mat map(kHigh, kWide, CV_16UC1);
  for (int y = 0; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x)
      map.at<std::uint16_t>(y, x) =
          y < kHorizon ? std::uint16_t{65535} : static_cast<std::uint16_t>(std::lround(10.0f * land_m(y)));
  cv::imwrite((folder() / "full.png").string(), map);
  DistanceFile file;
  EXPECT_THAT(read_distances(folder() / "full.png", file, kWide, kHigh).error().message, HasSubstr("--depth-step-m"));
  file.scale = 0.1;
  expect_landscape(read_distances(folder() / "full.png", file, kWide, kHigh), 0.0f);
  cv::Mat grey;
  cv::merge(std::vector{map, map, map}, grey);
  cv::imwrite((folder() / "full.png").string(), grey);
  expect_landscape(read_distances(folder() / "full.png", file, kWide, kHigh), 0.0f);
}

TEST(DistanceNumbers, DisparitiesAndNearnessBecomeDistances) {
  auto nearness = landscape(0.0f);
  for (float& value : nearness.elements())
    if (value > 0.0f) value = (1.0f / value - 1e-5f) / 0.002f;  // as a network's, by its scale and offset
  DistanceFile inverse;
  inverse.holds = DistanceFile::Holds::inverse;
  inverse.scale = 0.002;
  inverse.offset = 1e-5;
  inverse.sky_beyond_m = 50e3;
  expect_landscape(read_distances(pfm_of("inverse.pfm", nearness), inverse, kWide, kHigh), kSky);
  auto stereo = landscape(kSky);
  for (float& value : stereo.elements()) value = std::isinf(value) ? value : 4e5f / value - 3.0f;
  DistanceFile disparity;
  disparity.holds = DistanceFile::Holds::disparity;
  disparity.scale = 4e5;
  disparity.offset = 3.0;
  expect_landscape(read_distances(pfm_of("disparity.pfm", stereo), disparity, kWide, kHigh), 0.0f);
}

// As KITTI keeps them: 256 steps a pixel, up to 256 pixels.
TEST(DistanceNumbers, StepsOfDisparityMayBeLarge) {
  cv::Mat1w steps(kHigh, kWide);
  const auto land = landscape(0.0f);
  double nearest = 1e9;
  for (int y = 0; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x) nearest = land.at(x, y) > 0.0f ? std::min<double>(nearest, land.at(x, y)) : nearest;
  const double scale = 60'000.0 * nearest;  // so that the nearest is 60 000 steps
  for (int y = 0; y < kHigh; ++y)
    for (int x = 0; x < kWide; ++x)
      steps(y, x) = land.at(x, y) > 0.0f ? cv::saturate_cast<std::uint16_t>(scale / double{land.at(x, y)}) : 0;
  const auto file = folder() / "kitti.png";
  ASSERT_TRUE(cv::imwrite(file.string(), steps));
  DistanceFile disparity;
  disparity.holds = DistanceFile::Holds::disparity;
  disparity.scale = scale;
  const auto map = must(read_distances(file, disparity, kWide, kHigh));
  EXPECT_NEAR(map->near_m, nearest, 1e-4 * nearest);
}

TEST(DistanceNumbers, WhatIsUpsideDownOrRelativeIsTold) {
  auto nearness = landscape(0.0f);
  for (float& value : nearness.elements()) value = value > 0.0f ? 10000.0f / value : 0.0f;
  EXPECT_THAT(read_distances(pfm_of("nearer.pfm", nearness), {}, kWide, kHigh).error().message,
              HasSubstr("if these are metres, say so"));
  DistanceFile metres;
  metres.scale = 1.0;
  const auto told = must(read_distances(folder() / "nearer.pfm", metres, kWide, kHigh));
  EXPECT_THAT(told->summary(), HasSubstr("inverse depth?"));
  for (float& value : nearness.elements()) value *= 0.008f;
  EXPECT_THAT(read_distances(pfm_of("relative.pfm", nearness), {}, kWide, kHigh).error().message,
              HasSubstr("all within"));
}

TEST(DistanceNumbers, AMapOfNothingIsAnError) {
  for (const float nothing : {0.0f, 1e10f, std::numeric_limits<float>::quiet_NaN()}) {
    EXPECT_THAT(read_distances(pfm_of("nothing.pfm", Image<float>(kWide, kHigh, nothing)), {}, kWide, kHigh),
                FailsWith(HasSubstr("nothing is known in any pixel")));
  }
}

TEST(DistanceNumbers, AnotherSizeOfTheSameShapeIsResampled) {
  const auto half = must(read_distances(pfm_of("size.pfm", landscape(kSky)), {}, 2 * kWide, 2 * kHigh));
  EXPECT_THAT(half->summary(), HasSubstr("resampled from 60 x 40"));
  for (int y = 30; y < kHigh; ++y) {
    EXPECT_NEAR(half->metres.at(11, 2 * y), land_m(y), 0.1f * land_m(y)) << y;
    EXPECT_EQ(half->metres.at(11, 2 * kHorizon - 1), kSky);
  }
  EXPECT_FALSE(read_distances(folder() / "size.pfm", {}, 2 * kWide, 3 * kHigh));
}

// Every twentieth pixel of the land, and a lidar's lines.
TEST(DistanceNumbers, ASparseMapIsFilledUpToTheHorizonAndTold) {
  std::mt19937 random(3);
  for (const bool lines : {false, true}) {
    constexpr int kScale = 6;  // 360 x 240
    Image<float> map(kScale * kWide, kScale * kHigh);
    for (int y = kScale * kHorizon; y < map.height(); ++y)
      for (int x = 0; x < map.width(); ++x)
        if (lines ? y % 8 == 0 && x % 2 == 0 : random() % 20 == 0) map.at(x, y) = land_m(y / kScale);
    const auto read = must(read_distances(pfm_of("sparse.pfm", map), {}, map.width(), map.height()));
    EXPECT_THAT(read->summary(), HasSubstr("sparse, as a lidar's"));
    EXPECT_NEAR(read->known, 0.6, 0.03) << read->summary();
    double worst = 0.0;
    for (int y = kScale * (kHorizon + 4); y < map.height(); ++y)
      for (int x = 0; x < map.width(); ++x)
        worst = std::max(worst, std::abs(std::log(double(read->metres.at(x, y)) / double(land_m(y / kScale)))));
    EXPECT_LT(worst, 0.7) << "the nearest line's distance";
  }
}

// Channels are written by OpenEXR itself: names are what OpenCV does not know.
Result<DistanceMap> read_exr(const std::vector<std::pair<const char*, float>>& channels, const char* wanted = "") {
  Imf::Header header(kWide, kHigh);
  Imf::FrameBuffer source;
  std::vector<Image<float>> kept;
  kept.reserve(channels.size());
  for (const auto& [name, scale] : channels) {
    kept.push_back(landscape(1e10f, scale));
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    source.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(kept.back().elements().data()), sizeof(float),
                                   sizeof(float) * kWide));
  }
  {
    Imf::OutputFile file((folder() / "channels.exr").c_str(), header);
    file.setFrameBuffer(source);
    file.writePixels(kHigh);
  }
  DistanceFile file;
  file.channel = wanted;
  return read_distances(folder() / "channels.exr", file, kWide, kHigh);
}

TEST(DistanceNumbers, AnExrsChannelIsChosenByItsName) {
  for (const char* name : {"Z", "V", "Y", "R", "ViewLayer.Depth.Z", "depth", "distance.Y", "anything"})
    expect_landscape(read_exr({{name, 1.0f}}), kSky);
  expect_landscape(read_exr({{"R", 3.0f}, {"G", 2.0f}, {"B", 4.0f}, {"A", 5.0f}, {"Z", 1.0f}}), kSky);
  expect_landscape(read_exr({{"Image.R", 3.0f}, {"Image.G", 2.0f}, {"View.Depth.Z", 1.0f}}), kSky);
  expect_landscape(read_exr({{"R", 1.0f}, {"G", 1.0f}, {"B", 1.0f}}), kSky);
  expect_landscape(read_exr({{"Z", 3.0f}, {"mine", 1.0f}}, "mine"), kSky);
  EXPECT_THAT(read_exr({{"R", 3.0f}, {"G", 2.0f}, {"B", 4.0f}}).error().message, HasSubstr("--depth-channel"));
  EXPECT_THAT(read_exr({{"Z", 3.0f}}, "mine").error().message, HasSubstr("no channel mine: expected one of Z"));
}

}  // namespace
}  // namespace kasumi
