#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "pipeline/site/config/read_skyline.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

struct Read {
  Skyline skyline;
  std::string problems;
};

Read read_hills(const std::string& table) {
  const auto folder = test_output_folder() / "skyline";
  std::filesystem::create_directories(folder);
  EXPECT_TRUE(write_text_file(folder / "hills.csv", table));
  const auto root = ConfigTable::parse("skyline = \"hills.csv\"", folder / "kiosk.toml").value();
  Read done{read_skyline(root), {}};
  if (const auto whole = root.finish(); !whole) done.problems = whole.error().message;
  return done;
}

TEST(ReadSkyline, IsATableOfAzimuthsAndElevations) {
  const auto done = read_hills("note,elevation_deg,azimuth_deg\nwest,14.5,270\neast,3,90\n\n");
  EXPECT_EQ(done.problems, "");
  EXPECT_NEAR(done.skyline.elevation_deg(270.0), 14.5, 1e-9);
  EXPECT_NEAR(done.skyline.elevation_deg(0.0), 8.75, 1e-9);
}

TEST(ReadSkyline, TheRowThatClosesTheCircleIsNoRival) {
  EXPECT_EQ(read_hills("azimuth_deg,elevation_deg\n0,5\n180,1\n360,5\n").problems, "");
}

TEST(ReadSkyline, EveryProblemIsNamedAtOnce) {
  const auto problems = read_hills("azimuth_deg,elevation_deg\n0,5\n400,1\n90,steep\n0,6\n").problems;
  EXPECT_THAT(problems, HasSubstr("kiosk.toml: skyline = 'hills.csv': expected a table of azimuth_deg and"));
  EXPECT_THAT(problems, HasSubstr("hills.csv:3: column 1 (azimuth_deg): '400': expected a number from -360 to 360"));
  EXPECT_THAT(problems, HasSubstr("hills.csv:4: column 2 (elevation_deg): 'steep': expected a number from -10 to 90"));
  EXPECT_THAT(problems, HasSubstr("elevation_deg = 5 and 6 at azimuth_deg = 0: expected one"));
}

TEST(ReadSkyline, MissingColumnsRowsAndFilesAreNamed) {
  EXPECT_THAT(read_hills("azimuth,elevation_deg\n0,5\n90,1\n").problems,
              HasSubstr("hills.csv:1: column azimuth_deg is missing"));
  EXPECT_THAT(read_hills("azimuth_deg,elevation_deg\n0,5\n").problems, HasSubstr("1 rows: expected 2 to 3600"));
  const auto root = ConfigTable::parse("skyline = \"absent.csv\"", test_output_folder() / "kiosk.toml").value();
  EXPECT_EQ(read_skyline(root).elevation_deg(10.0), 0.0);
  EXPECT_THAT(root.finish(), FailsWith(HasSubstr("absent.csv")));
}

}  // namespace
}  // namespace kasumi
