// The sky of Hosek and Wilkie against pictures that others drew of it, and what becomes of damaged data.
#include "estimator/sky/hosek.hpp"

#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "estimator/sky/sun.hpp"
#include "tests/estimator/sky/spectral_exr.hpp"
#include "tests/places.hpp"

namespace kasumi::test {
namespace {

using namespace std::chrono_literals;

// The direction of a pixel's middle in a picture that spans all azimuths from left to right, zenith to nadir downwards.
Direction direction_of(const Image<float>& picture, int x, int y) {
  return direction_from(Radians{std::numbers::pi * (y + 0.5) / picture.height()},
                        Radians{2.0 * std::numbers::pi * (x + 0.5) / picture.width()});
}

class HosekPictures : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!exists(folder_ / "sunsky_datasets.bin")) GTEST_SKIP() << "no shared/data/sky/hosek";
    auto read = HosekSky::read_file(folder_ / "sunsky_datasets.bin");
    ASSERT_TRUE(read) << read.error().message;
    hosek_ = std::move(*read);
  }
  const std::filesystem::path folder_ = shared_data_folder() / "sky" / "hosek";
  HosekSky hosek_;
};

TEST_F(HosekPictures, ColoursAreThoseOfTheReferencePicture) {
  auto picture = read_exr(folder_ / "sky_rgb_hour9.50_t2.000_a0.200.exr");
  // Half past nine in Tokyo (35.6894 N 139.6917 E) on 10 July 2010, by the ephemeris that drew the picture.
  const auto sun = direction_from(from_degrees(90.0 - 57.48173), from_degrees(104.99613));
  const Site tokyo{"", 35.6894, 139.6917, 0.0};
  const Utc half_past_nine = std::chrono::sys_days{2010y / 7 / 10} + 30min;
  const auto ours = sun_position(half_past_nine, tokyo).direction;
  EXPECT_LT(to_degrees(angle_between(sun, ours)), 0.1);
  double worst = 0.0;
  const auto sky = hosek_.sky(Turbidity{2.0}, 0.2, sun);
  for (int y = 0; y < picture["R"].height() / 2; ++y)
    for (int x = 0; x < picture["R"].width(); ++x) {
      const auto light = sky.linear_srgb(direction_of(picture["R"], x, y));
      worst = std::max({worst, std::abs(light.r / double{picture["R"].at(x, y)} - 1.0),
                        std::abs(light.g / double{picture["G"].at(x, y)} - 1.0),
                        std::abs(light.b / double{picture["B"].at(x, y)} - 1.0)});
    }
  fmt::print("Hosek, colours: {:.1e} off at worst (1e-3)\n", worst);
  EXPECT_LT(worst, 1e-3);
}

TEST_F(HosekPictures, SpectrumIsThatOfTheReferencePicture) {
  auto picture = read_exr(folder_ / "sky_spec_eta0.349_t5.200_a0.000.exr");
  const auto sun = direction_from(from_degrees(70.0), from_degrees(180.0));
  double worst = 0.0;
  // Each channel is the light at the middle of its 47 nm; the data end at 720 nm.
  for (int channel = 0; channel < 8; ++channel) {
    const double first_nm = 360.0 + 47.0 * channel, at = (first_nm + 23.5 - HosekSky::kFirst_nm) / HosekSky::kStep_nm;
    const auto& measured = picture.at(fmt::format("{:.2f}-{:.2f}nm", first_nm, first_nm + 47.0));
    for (int y = 0; y < measured.height() / 2; ++y)
      for (int x = 0; x < measured.width(); ++x) {
        const auto light = hosek_.spectral_radiance(Turbidity{5.2}, 0.0, sun, direction_of(measured, x, y));
        const auto below = static_cast<std::size_t>(at);
        const double ours = std::lerp(light[below], light[below + 1], at - std::floor(at));
        worst = std::max(worst, std::abs(ours / double{measured.at(x, y)} - 1.0));
      }
  }
  fmt::print("Hosek, spectrum: {:.1e} off at worst (1e-3)\n", worst);
  EXPECT_LT(worst, 1e-3);
}

// The colours are the spectrum's, seen by the eye: both parts of the data are read as what they are.
TEST_F(HosekPictures, ColoursAndSpectrumTellTheSameLuminance) {
  const auto sun = direction_from(from_degrees(50.0), from_degrees(30.0));
  for (const double turbidity : {1.0, 2.7, 6.4, 10.0})
    for (const double zenith : {5.0, 40.0, 80.0}) {
      const auto view = direction_from(from_degrees(zenith), from_degrees(200.0));
      const auto rgb = hosek_.linear_srgb(Turbidity{turbidity}, 0.3, sun, view);
      const auto spectrum = hosek_.spectral_radiance(Turbidity{turbidity}, 0.3, sun, view);
      const double luminance = 0.2126 * rgb.r + 0.7152 * rgb.g + 0.0722 * rgb.b;
      // y-bar at 400, 440 ... 720 nm, CIE 1931; 40 nm are coarse for it.
      const double eye = 0.0004 * spectrum[2] + 0.023 * spectrum[3] + 0.139 * spectrum[4] + 0.710 * spectrum[5] +
                         0.995 * spectrum[6] + 0.631 * spectrum[7] + 0.175 * spectrum[8] + 0.017 * spectrum[9] +
                         0.001 * spectrum[10];
      EXPECT_NEAR(luminance / (40.0 * eye / 106.857), 1.0, 0.03) << "T " << turbidity << ", zenith " << zenith;
    }
}

TEST_F(HosekPictures, OutOfRangeIsClamped) {
  const auto sun = direction_from(from_degrees(60.0), from_degrees(0.0));
  const auto view = direction_from(from_degrees(30.0), from_degrees(90.0));
  EXPECT_EQ(hosek_.linear_srgb(Turbidity{0.2}, -1.0, sun, view), hosek_.linear_srgb(Turbidity{1.0}, 0.0, sun, view));
  EXPECT_EQ(hosek_.linear_srgb(Turbidity{12.0}, 2.0, sun, view), hosek_.linear_srgb(Turbidity{10.0}, 1.0, sun, view));
  const auto below = hosek_.linear_srgb(Turbidity{3.0}, 0.2, sun, direction_from(from_degrees(100.0), Radians{0.0}));
  EXPECT_TRUE(std::isfinite(below.r) && below.r > 0.0);
  const auto sunk = direction_from(from_degrees(100.0), Radians{0.0});
  EXPECT_TRUE(std::isfinite(hosek_.linear_srgb(Turbidity{3.0}, 0.2, sunk, view).g));
}

// A file of the same layout whose numbers a test may choose.
class HosekData {
 public:
  HosekData() {
    add("sky_params_rgb", {10, 2, 6, 3, 9});
    add("sky_rad_rgb", {10, 2, 6, 3});
    add("sky_params_spec", {10, 2, 6, 11, 9});
    add("sky_rad_spec", {10, 2, 6, 11});
  }
  struct Tensor {
    std::string name;
    std::uint8_t type = 11;
    std::vector<std::uint64_t> shape;
    std::vector<double> values;
  };
  std::vector<Tensor> tensors;
  std::vector<std::uint8_t> bytes() const {
    std::vector<std::uint8_t> bytes;
    const auto put = [&](const void* from, std::size_t count) {
      const auto* p = static_cast<const std::uint8_t*>(from);
      bytes.insert(bytes.end(), p, p + count);
    };
    const auto number = [&](auto value) { put(&value, sizeof value); };
    put("tensor_file\0\1\0", 14);
    number(static_cast<std::uint32_t>(tensors.size()));
    std::uint64_t offset = 18;
    for (const auto& tensor : tensors) offset += 2 + tensor.name.size() + 11 + 8 * tensor.shape.size();
    for (const auto& tensor : tensors) {
      number(static_cast<std::uint16_t>(tensor.name.size()));
      put(tensor.name.data(), tensor.name.size());
      number(static_cast<std::uint16_t>(tensor.shape.size()));
      number(tensor.type);
      number(offset);
      for (const auto extent : tensor.shape) number(extent);
      offset += 8 * tensor.values.size();
    }
    for (const auto& tensor : tensors) put(tensor.values.data(), 8 * tensor.values.size());
    return bytes;
  }
  Tensor& at(std::size_t i) { return tensors[i]; }

 private:
  void add(const char* name, std::vector<std::uint64_t> shape) {
    std::size_t count = 1;
    for (const auto extent : shape) count *= extent;
    tensors.push_back({name, 11, std::move(shape), std::vector<double>(count, 0.5)});
  }
};

Result<HosekSky> read(const std::vector<std::uint8_t>& bytes) {
  std::filesystem::create_directories(test_output_folder());
  const auto file = test_output_folder() / "hosek.bin";
  EXPECT_TRUE(write_file(file, bytes));
  return HosekSky::read_file(file);
}

void expect_refused(const std::vector<std::uint8_t>& bytes, const std::string& says) {
  const auto sky = read(bytes);
  ASSERT_FALSE(sky) << says;
  EXPECT_EQ(sky.error().kind, FaultKind::bad_input);
  EXPECT_NE(sky.error().message.find("hosek.bin: "), std::string::npos) << sky.error().message;
  EXPECT_NE(sky.error().message.find(says), std::string::npos) << sky.error().message;
}

TEST(HosekFile, OfTheLayoutIsRead) {
  EXPECT_TRUE(read(HosekData().bytes()));
}

TEST(HosekFile, DamagedIsRefused) {
  expect_refused({}, "expected a file of tensors");
  expect_refused({'P', 'N', 'G'}, "expected a file of tensors");
  const auto whole = HosekData().bytes();
  for (const std::size_t size : {15, 30, 40, 100}) {
    auto cut = whole;
    cut.resize(size);
    expect_refused(cut, "within the list");
  }
  auto cut = whole;
  cut.pop_back();
  expect_refused(cut, "'sky_rad_spec' begins at byte");
  auto newer = whole;
  newer[12] = 2;
  expect_refused(newer, "version 2 of a file of tensors: expected 1");
  auto crowded = whole;
  crowded[16] = 200;
  expect_refused(crowded, "tensors: expected at most");

  HosekData data;
  data.at(1).name = "sky_red_rgb";
  expect_refused(data.bytes(), "has no tensor 'sky_rad_rgb'");
  data = {};
  data.at(0).type = 10;
  expect_refused(data.bytes(), "'sky_params_rgb' is of type 10: expected 11");
  data = {};
  data.at(2).shape = {10, 2, 6, 9, 11};
  expect_refused(data.bytes(), "'sky_params_spec' is 10 x 2 x 6 x 9 x 11: expected 10 x 2 x 6 x 11 x 9");
  data = {};
  data.at(3).values[7] = std::numeric_limits<double>::quiet_NaN();
  expect_refused(data.bytes(), "'sky_rad_spec': number 8 is nan");
}

TEST(HosekFile, MissingIsRefused) {
  EXPECT_FALSE(HosekSky::read_file(test_output_folder() / "no such file.bin"));
}

}  // namespace
}  // namespace kasumi::test
