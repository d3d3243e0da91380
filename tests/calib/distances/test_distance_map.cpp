// Depth maps, written byte by byte or by OpenCV's PNG writer.
#include <cstring>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "base/files.hpp"
#include "calib/distances/distance_map.hpp"
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
  EXPECT_THAT(read("depth_map = 'words.png'\n" + step).problems, HasSubstr("'words.png': expected a grey PNG"));
  EXPECT_THAT(read("depth_map = 'nothing.png'\n" + step).problems, HasSubstr("'nothing.png': expected a grey PNG"));
  EXPECT_THAT(read("depth_map = 'absent.png'\n" + step).problems,
              HasSubstr("scene.depth_map = 'absent.png': expected an existing file"));
  EXPECT_THAT(read("depth_map = 'depth.png'\n").problems, HasSubstr("scene.depth_step_m is missing"));
  EXPECT_THAT(read("depth_map = 'depth.png'\ndepth_step_m = 0\n").problems, HasSubstr("scene.depth_step_m = 0"));
  EXPECT_THAT(read(step).problems, HasSubstr("scene.depth_step_m = 1"));
}

TEST(DistanceMap, InvalidDistancesAreReportedWithTheirPosition) {
  write_pfm("negative.pfm", [](int x, int y) { return x == 2 && y == 1 ? -3.5f : 100.0f; });
  write_pfm("nan.pfm", [](int x, int) { return x == 1 ? std::numeric_limits<float>::quiet_NaN() : 100.0f; });
  EXPECT_THAT(read("depth_map = 'negative.pfm'\n").problems, HasSubstr("pixel 2, 1 is -3.5"));
  EXPECT_THAT(read("depth_map = 'nan.pfm'\n").problems, HasSubstr("pixel 1, 0 is nan"));
  EXPECT_THAT(read("depth_map = 'negative.pfm'\ndepth_step_m = 1\n").problems,
              testing::AllOf(HasSubstr("a PFM is in metres"), HasSubstr("pixel 2, 1")));
}

}  // namespace
}  // namespace kasumi
