// Visibility from landmarks against an instrument's.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "pipeline/lab/photographs/measured_visibility.hpp"
#include "pipeline/lab/photographs/visibility_series.hpp"
#include "tests/environment.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

std::filesystem::path table_of(const std::string& text) {
  const auto file = test_folder("measured-visibility") / "visibility.csv";
  std::filesystem::create_directories(file.parent_path());
  EXPECT_TRUE(write_text_file(file, text));
  return file;
}

TEST(MeasuredVisibility, IsReadByThePicturesName) {
  const auto read = must(read_measured_visibilities(table_of("name,visibility_m\na.jpg,1620\r\n\nb.jpg,73.5\n")));
  EXPECT_EQ(*read, (MeasuredVisibilities{{"a.jpg", 1620.0}, {"b.jpg", 73.5}}));
}

TEST(MeasuredVisibility, EveryWrongLineIsNamed) {
  const auto read = read_measured_visibilities(table_of("name,visibility_m\na.jpg,far\nb.jpg\nc.jpg,-3\nd.jpg,nan\n"));
  ASSERT_FALSE(read);
  for (const char* line : {"line 2", "line 3", "line 4", "line 5"}) EXPECT_THAT(read.error().message, HasSubstr(line));
  EXPECT_FALSE(read_measured_visibilities(table_of("picture,km\na.jpg,3\n")));
}

ChannelExtinctions air_of(ExtinctionKind kind, double per_m, double sigma_per_m) {
  ChannelExtinctions air;
  for (auto& channel : air.channels) {
    channel.kind = kind;
    channel.per_m = per_m;
    channel.sigma_per_m = sigma_per_m;
    channel.lowest_per_m = per_m;
    channel.highest_per_m = per_m;
  }
  return air;
}

// An optical range of 1 km is an extinction of ln 20 per km.
TEST(MeasuredVisibility, IsComparedInSigmasOfTheExtinction) {
  const double per_m = std::log(20.0) / 1000.0;
  const auto same = check_visibility(air_of(ExtinctionKind::value, per_m, 1e-4), 1000.0);
  EXPECT_NEAR(same.factor, 1.0, 1e-3);
  EXPECT_NEAR(same.sigmas, 0.0, 0.01);
  const auto thicker = check_visibility(air_of(ExtinctionKind::value, per_m + 3e-4, 1e-4), 1000.0);
  EXPECT_NEAR(thicker.sigmas, 3.0, 0.01);
  EXPECT_LT(thicker.factor, 1.0);
  EXPECT_TRUE(same.holds);
  EXPECT_FALSE(thicker.holds);
  const auto bound = air_of(ExtinctionKind::at_most, per_m, 1e-4);
  EXPECT_TRUE(check_visibility(bound, 5000.0).holds);
  EXPECT_FALSE(check_visibility(bound, 500.0).holds);
  EXPECT_FALSE(check_visibility({}, 500.0).holds);
  EXPECT_THAT(checks_text({same, thicker, check_visibility(bound, 500.0)}),
              HasSubstr("measured beside 3 pictures: 2 of them give a value"));
}

// Koschmieder on a real meadow: the instrument stands beside the camera, but the air is not everywhere the same.
TEST(MeasuredVisibility, OfTheMeadowOfDeBiltIsComparedByOneCommand) {
  const auto folder = shared_data_folder() / "haze/knmi-debilt";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const auto command =
      fmt::format("estimate --scene {} --landmarks {} --measured {}", folder.string(),
                  (source_folder() / "tests/paper/knmi-debilt.toml").string(), (folder / "visibility.csv").string());
  const auto said = ended(0, run_kasumi(command));
  fmt::print("{}", said.out);
  const auto outcome = ended(0, run_kasumi(command + " --json"));
  std::istringstream lines(outcome.out);
  int values = 0, bounds = 0, nothing = 0, within_factor = 0, within_sigmas = 0;
  for (std::string line; std::getline(lines, line);) {
    const auto json = parse_json(line);
    const auto& measured = json["measured"];
    ASSERT_FALSE(measured.is_null()) << json["scene"];
    if (json["visibility"] == "nothing") {
      ++nothing;
    } else if (json["visibility"] == "value") {
      ++values;
      within_factor += std::abs(std::log(measured["factor"].get<double>())) < std::log(1.5) ? 1 : 0;
      within_sigmas += std::abs(measured["sigmas"].get<double>()) < 3.0 ? 1 : 0;
    } else {
      ++bounds;
      EXPECT_TRUE(measured["holds"].get<bool>()) << line;
    }
  }
  EXPECT_EQ(nothing, 8) << "infrared, by night";
  EXPECT_EQ(bounds, 5) << "clearer than 350 m can tell";
  EXPECT_EQ(values, 4) << "in fog and mist";
  EXPECT_GE(within_factor, 2);
  EXPECT_GE(within_sigmas, 2);
}

// Names carry the time, the order in which they are given nothing.
TEST(MeasuredVisibility, OfTheMeadowOfDeBiltIsTheSameInAnyOrder) {
  const auto folder = shared_data_folder() / "haze/knmi-debilt";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  std::vector<std::filesystem::path> pictures;
  for (const char* time : {"1004_0650", "1009_0850", "1017_0630", "1006_0620", "1010_0830", "1006_1430", "1007_0650"})
    pictures.push_back(folder / fmt::format("Meetterrein_2015{}.jpg", time));
  const auto landmarks = source_folder() / "tests/paper/knmi-debilt.toml";
  const auto given = read_visibilities(pictures, landmarks);
  std::ranges::sort(pictures);
  const auto in_time = read_visibilities(pictures, landmarks);
  ASSERT_TRUE(given && in_time);
  for (const auto& one : given->pictures) {
    const auto same = std::ranges::find(in_time->pictures, one.picture, &VisibilityReading::picture);
    ASSERT_NE(same, in_time->pictures.end());
    EXPECT_EQ(one.air.extinction().per_m, same->air.extinction().per_m) << one.picture;
  }
}

}  // namespace
}  // namespace kasumi
