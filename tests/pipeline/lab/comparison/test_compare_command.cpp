// `kasumi compare` as a researcher's script calls it.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "pipeline/site/files/photograph_file.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

class CompareCommand : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder);
    Image<Rgb8> one(40, 30), other(40, 30), half(40, 30), night(40, 30);
    for (int y = 0; y < 30; ++y)
      for (int x = 0; x < 40; ++x) {
        one.at(x, y) = Rgb8(5 * x, 7 * y, 90);
        other.at(x, y) = x < 20 ? one.at(x, y) : Rgb8(5 * x, 7 * y, 96);
        half.at(x, y) = Rgb8(x < 20 ? 255 : 0);
      }
    for (const auto& [name, picture] : {std::pair{"one", &one}, {"other", &other}, {"half", &half}, {"night", &night}})
      ASSERT_TRUE(write_png(at(name), *picture));
    ASSERT_TRUE(write_png(at("small"), Image<Rgb8>(39, 30)));
  }
  std::string at(const std::string& name) const { return (folder / (name + ".png")).string(); }
  Outcome compare(const std::string& a, const std::string& b, const std::string& options = "") const {
    return run_kasumi(fmt::format("compare {} {} {}", at(a), at(b), options));
  }
  const std::filesystem::path folder = test_folder("compare");
};

TEST_F(CompareCommand, SaysHowAlikeTwoPicturesAre) {
  const auto outcome = ended(0, compare("one", "other", "--json"));
  const auto json = parse_json(outcome.out);
  EXPECT_EQ(json["pixels"], 1200);
  EXPECT_FALSE(json["equal"]);
  EXPECT_NEAR(json["mean_error"].get<double>(), 1.0, 1e-4) << "6 steps of one channel of three in half the picture";
  EXPECT_NEAR(json["largest_error"].get<double>(), 6.0, 1e-3);
  EXPECT_NEAR(json["psnr_db"].get<double>(), 10.0 * std::log10(255.0 * 255.0 / 6.0), 1e-3);
  EXPECT_GT(json["ssim"].get<double>(), 0.99);
  for (const char* key : {"mean", "at_95_percent", "largest"}) EXPECT_GT(json["ciede2000"][key], 0.0) << key;
  for (const char* key : {"hue", "saturation", "value", "combined"})
    EXPECT_LE(json["hsv_correlation"][key], 1.0) << key;
  EXPECT_THAT(compare("one", "other").out, HasSubstr("PSNR             40.35 dB"));
}

TEST_F(CompareCommand, UnderAMaskOnlyItsWhiteCounts) {
  const auto outcome = ended(0, compare("one", "other", "--json --mask " + at("half")));
  const auto json = parse_json(outcome.out);
  EXPECT_EQ(json["pixels"], 600);
  EXPECT_TRUE(json["equal"]);
  EXPECT_TRUE(json["psnr_db"].is_null());
  EXPECT_NEAR(json["ssim"].get<double>(), 1.0, 1e-9);
  EXPECT_THAT(compare("one", "other", "--mask " + at("half")).out, HasSubstr("equal"));
}

TEST_F(CompareCommand, SixteenBitsAreSeen) {
  Photograph fine;
  fine.quantum = 1.0 / 65535.0;
  fine.encoded = Image<glm::vec3>(20, 20, glm::vec3(0.5F));
  ASSERT_TRUE(write_photograph(at("fine"), fine));
  for (auto& pixel : fine.encoded.elements()) pixel += 0.25F / 255.0F;
  ASSERT_TRUE(write_photograph(at("finer"), fine));
  const auto outcome = ended(0, compare("fine", "finer", "--json"));
  EXPECT_NEAR(parse_json(outcome.out)["mean_error"].get<double>(), 0.25, 0.01);
}

TEST_F(CompareCommand, WhatCannotBeComparedIsRefused) {
  EXPECT_THAT(ended(2, compare("one", "small")).err, HasSubstr("small.png: is 39 x 30: expected 40 x 30"));
  EXPECT_THAT(ended(2, compare("one", "other", "--mask " + at("small"))).err, HasSubstr("small.png"));
  EXPECT_THAT(ended(2, compare("one", "other", "--mask " + at("night"))).err, HasSubstr("night.png: all black"));
  const auto missing = compare("one", "missing");
  EXPECT_NE(missing.code, 0);
  EXPECT_THAT(missing.err, HasSubstr("missing.png"));
  EXPECT_EQ(run_kasumi("compare " + at("one")).code, 2);
}

}  // namespace
}  // namespace kasumi
