#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include <glm/geometric.hpp>

#include "pipeline/site/config/placement.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

const Site kNara{"Nara", 34.69, 135.80, 100.0};

TEST(Placement, ThePlaceOfTheSiteIsItsOrigin) {
  EXPECT_NEAR(glm::length(east_north_up(kNara, 34.69, 135.80, 100.0)), 0.0, 1e-6);
}

TEST(Placement, AMinuteOfLatitudeIsAboutANauticalMileNorth) {
  const auto offset = east_north_up(kNara, 34.69 + 1.0 / 60.0, 135.80, 100.0);
  EXPECT_NEAR(offset.y, 1849.0, 1.0);  // meridian arc at 34.7 deg on WGS 84: 110.92 km per degree
  EXPECT_NEAR(offset.x, 0.0, 1e-6);
}

TEST(Placement, AMinuteOfLongitudeShrinksWithTheCosineOfLatitude) {
  const auto offset = east_north_up(kNara, 34.69, 135.80 + 1.0 / 60.0, 100.0);
  // The prime vertical's radius N = a / sqrt(1 - e2 sin2) and cos of latitude.
  const double s = std::sin(34.69 * kPi / 180.0), e2 = 0.00669437999014;
  const double n = 6378137.0 / std::sqrt(1.0 - e2 * s * s) + 100.0;
  EXPECT_NEAR(offset.x, n * std::cos(34.69 * kPi / 180.0) * kPi / 180.0 / 60.0, 0.01);
}

TEST(Placement, TheEarthCurvesAwayByDistanceSquaredOverItsDiameter) {
  const auto offset = east_north_up(kNara, 34.69 + 0.0315, 135.80, 100.0);  // about 3.5 km
  const double distance = std::hypot(offset.x, offset.y);
  EXPECT_NEAR(offset.z, -distance * distance / (2.0 * 6.36e6), 0.02);  // metres
}

TEST(Placement, RefractionLiftsFarPlacesByAnEighthOfTheCurvature) {
  EXPECT_NEAR(lift_by_refraction(3500.0), 0.125, 0.001);  // metres: .13 x 3500^2 / (2 x 6371 km)
  EXPECT_NEAR(lift_by_refraction(20e3), 4.08, 0.01);
  EXPECT_EQ(lift_by_refraction(20e3, 0.0), 0.0);
}

class PlacementFile : public testing::Test {
 protected:
  Result<> read(const std::string& keys) {
    const auto folder = test_output_folder() / "placement";
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "a.glb") << "glTF";
    const auto root = ConfigTable::parse("[object]\nmodel = 'a.glb'\n" + keys, folder / "f.toml").value();
    object = read_placement(root.table("object"), kNara);
    return root.finish();
  }
  ObjectPlacement object;
};

TEST_F(PlacementFile, MetresAreUsedUnchanged) {
  ASSERT_TRUE(read("east_m = 10\nnorth_m = 3500.5\nup_m = -20\nheading_deg = 90\nscale = 2"));
  EXPECT_EQ(object.placement.east_m, 10);
  EXPECT_EQ(object.placement.north_m, 3500.5);
  EXPECT_EQ(object.placement.up_m, -20);
  EXPECT_NEAR(object.placement.heading.value, kPi / 2, 1e-12);
  EXPECT_EQ(object.placement.scale, 2);
}

TEST_F(PlacementFile, AModelMayHaveItsZUp) {
  const std::string place = "east_m = 0\nnorth_m = 3500\nup_m = 0\n";
  ASSERT_TRUE(read(place));
  EXPECT_EQ(object.placement.up_axis, UpAxis::y);
  ASSERT_TRUE(read(place + "up = 'z'"));
  EXPECT_EQ(object.placement.up_axis, UpAxis::z);
  EXPECT_THAT(read(place + "up = 'x'").error().message, testing::HasSubstr("object.up"));
}

TEST_F(PlacementFile, APlaceOnEarthIsTurnedIntoMetres) {
  ASSERT_TRUE(read("latitude_deg = 34.7215\nlongitude_deg = 135.8\naltitude_m = 180"));
  EXPECT_NEAR(object.placement.north_m, 3494, 3);
  EXPECT_NEAR(object.placement.up_m, 79, 0.2);
}

TEST_F(PlacementFile, RefractionAppliesOnlyToGeographicPlaces) {
  const std::string place = "latitude_deg = 34.8691\nlongitude_deg = 135.8\naltitude_m = 180\n";  // 20 km
  ASSERT_TRUE(read(place));
  const double usual = object.placement.up_m;
  ASSERT_TRUE(read(place + "refraction = 0.0"));
  EXPECT_NEAR(usual - object.placement.up_m, 4.0, 0.1);
  EXPECT_FALSE(read("east_m = 1\nnorth_m = 2\nup_m = 3\nrefraction = 0.2"));
}

TEST_F(PlacementFile, BothKindsOfPlaceAtOnceAreRejected) {
  EXPECT_THAT(read("east_m = 1\nnorth_m = 2\nup_m = 3\nlatitude_deg = 34\nlongitude_deg = 135\naltitude_m = 1"),
              FailsWith(testing::HasSubstr("not both")));
}

TEST_F(PlacementFile, EveryProblemOfThePlaceIsNamed) {
  const auto result = read("east_m = 'far'\nscale = 0\nheading_deg = nan");
  ASSERT_FALSE(result);
  for (const char* key : {"object.east_m", "object.north_m is missing", "object.up_m is missing", "object.scale = 0",
                          "object.heading_deg"})
    EXPECT_THAT(result.error().message, testing::HasSubstr(key));
}

}  // namespace
}  // namespace kasumi
