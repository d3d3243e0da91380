// kasumi calibrate scene, from a list of landmarks to the file with the camera's pose.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "base/utc_text.hpp"
#include "calib/calibration_file.hpp"
#include "fixtures/spectrum/sunlight.hpp"
#include "pipeline/site/config/placement.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/install/calibrate/calibrating.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

constexpr int kSceneWidth = 960, kSceneHeight = 540;
const Site kSite{"", 46.94, 8.28, 1450.0};

struct Place {
  const char* name;
  double latitude_deg, longitude_deg, altitude_m;
};
// North to north-east, 2 to 41 km away; at 41 km the earth's curvature lowers a place by 130 m, .18 deg.
constexpr std::array kPlaces{
    Place{"Kirche", 46.958, 8.290, 1380.0},        Place{"Turm \"am Berg\"", 47.020, 8.330, 1700.0},
    Place{"Sendemast", 47.060, 8.360, 1810.0},     Place{"Gipfelkreuz", 47.110, 8.440, 2010.0},
    Place{"Burg", 46.990, 8.330, 1290.0},          Place{"Horn", 47.190, 8.500, 2180.0},
    Place{"ferner Gipfel", 47.270, 8.530, 1820.0},
};

// Where refraction makes it appear: k d^2 / 2R above the straight line, as surveyors compute it.
glm::dvec3 apparent_direction(const Place& place) {
  auto at = east_north_up(kSite, place.latitude_deg, place.longitude_deg, place.altitude_m);
  const double distance_m = std::hypot(at.x, at.y);
  at.z += 0.13 * distance_m * distance_m / (2.0 * 6371e3);
  return at;
}

struct Truth {
  LensPtr lens = pinhole_lens({{1900.0, 1900.0}, {481.0, 268.0}, {}});
  glm::dmat3 to_world = camera_to_world(from_degrees(26.0), from_degrees(1.2), from_degrees(-1.5));
};

std::string landmarks(const Truth& truth, double focal_px, std::size_t wrong) {
  std::string text = fmt::format(
      "place_sigma_m = 0.5\n[site]\nlatitude_deg = {}\nlongitude_deg = {}\naltitude_m = {}\n[scene]\nwidth = "
      "{}\nheight = "
      "{}\nresponse = \"srgb\"\n[scene.lens]\nmodel = \"pinhole\"\nfocal_px = [{}, {}]\ncentre_px = [481.0, 268.0]\n",
      kSite.latitude_deg, kSite.longitude_deg, kSite.altitude_m, kSceneWidth, kSceneHeight, focal_px, focal_px);
  std::mt19937_64 random(3);
  const auto noise = [&] { return static_cast<double>(random() >> 11) * 0x1.0p-53 * 1.6 - 0.8; };
  for (std::size_t i = 0; i < kPlaces.size(); ++i) {
    auto pixel = truth.lens->project(apparent_direction(kPlaces[i]) * truth.to_world).value();
    pixel += glm::dvec2{noise(), noise()};
    if (i == wrong) pixel += glm::dvec2{-45.0, 12.0};
    text += fmt::format(
        "[[landmarks]]\nname = '{}'\nlatitude_deg = {}\nlongitude_deg = {}\naltitude_m = {}\npixel = [{:.1f}, "
        "{:.1f}]\n",
        kPlaces[i].name, kPlaces[i].latitude_deg, kPlaces[i].longitude_deg, kPlaces[i].altitude_m, pixel.x, pixel.y);
  }
  return text;
}

TEST(CalibrateScene, LandmarksOnTheMapGiveTheCamerasPoseAndAWrongOneIsNamed) {
  const auto folder = fresh_folder("calibrate-scene");
  const Truth truth;
  ASSERT_TRUE(write_png(folder / "scene.png", Image<Rgb8>(kSceneWidth, kSceneHeight, Rgb8(150, 170, 190))));
  ASSERT_TRUE(write_text_file(folder / "landmarks.toml", landmarks(truth, 1.02 * 1900.0, 2)));
  const auto file = folder / "calibration.toml";
  const auto outcome =
      run(fmt::format("scene {} --picture {} --serial SC-7 --out {}", (folder / "landmarks.toml").string(),
                      (folder / "scene.png").string(), file.string()));
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  std::printf("%s", outcome.out.c_str());
  EXPECT_THAT(outcome.out, HasSubstr("Sendemast: left out"));

  const auto root = ConfigTable::read_file(file).value();
  const auto found = read_camera(root.table("scene"), "scene");
  EXPECT_LE(to_degrees(angle_between(found.to_world[2], truth.to_world[2])), 0.03);
  for (const glm::dvec2 pixel : {glm::dvec2(0, 0), glm::dvec2(959, 0), glm::dvec2(500, 539)})
    EXPECT_LE(to_degrees(angle_between(found.direction_at(pixel).value(),
                                       truth.to_world * truth.lens->unproject(pixel).value())),
              0.08);
  const auto measured = root.table("scene").table("measured").table("pose");
  EXPECT_THAT(measured.text("from"), HasSubstr("6 of 7 landmarks"));
  EXPECT_NEAR(measured.number("focal_scale"), 1.0 / 1.02, 0.003);
  EXPECT_EQ(read_site(root.table("site")).latitude_deg, kSite.latitude_deg);
  EXPECT_GT(std::filesystem::file_size(folder / "calibration.scene-pose.png"), 1000u);

  // A second run with the file's own values: the old file is kept, and the lens need not be given again.
  auto again = landmarks(truth, 1900.0, 99);
  again.erase(again.find("[scene]"), again.find("[[landmarks]]") - again.find("[scene]"));
  ASSERT_TRUE(write_text_file(folder / "landmarks.toml", again));
  ended(0, run(fmt::format("scene {} --picture {} --out {}", (folder / "landmarks.toml").string(),
                           (folder / "scene.png").string(), file.string())));
  EXPECT_TRUE(std::filesystem::exists(file.string() + ".1.old"));
  EXPECT_EQ(ConfigTable::read_file(file).value().table("scene").text("serial"), "SC-7");
}

// The sun by a different ephemeris than the command's, over a lake's horizon, with the camera facing the sunset.
TEST(CalibrateScene, ThreeSightingsOfTheSettingSunAndTheHorizonGiveThePose) {
  const auto folder = fresh_folder("calibrate-scene-sun");
  ASSERT_TRUE(write_png(folder / "scene.png", Image<Rgb8>(kSceneWidth, kSceneHeight, Rgb8(150, 170, 190))));
  const Truth wide;
  // 20 deg across.
  const Truth truth{pinhole_lens({{2700.0, 2700.0}, {481.0, 268.0}, {}}),
                    camera_to_world(from_degrees(263.0), from_degrees(3.5), from_degrees(0.8))};
  auto text = landmarks(wide, 2700.0, 99);
  text.erase(text.find("[[landmarks]]"));
  std::mt19937_64 random(8);
  const auto noise = [&] {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(random() >> 11) * 0x1.0p-53;
    return sum;
  };
  for (const char* time : {"2026-09-12T16:50:00", "2026-09-12T17:05:30", "2026-09-12T17:18:00"}) {
    const auto utc = parse_utc(std::string(time) + "Z").value();
    const auto pixel = truth.lens->project(fixtures::sun_position(utc, kSite) * truth.to_world);
    ASSERT_TRUE(pixel && pixel->x > 0.0 && pixel->x < kSceneWidth && pixel->y > 0.0 && pixel->y < kSceneHeight) << time;
    text += fmt::format("[[sightings]]\nof = \"sun\"\nutc = {}Z\npixel = [{:.1f}, {:.1f}]\n", time, pixel->x + noise(),
                        pixel->y + noise());
  }
  // 1016 m above the water: Bowditch's dip of 1.76' sqrt(h / m), .935 deg, which includes the refraction over the sea.
  text = "refraction = 0.16\n" + text + "[horizon]\nwater_altitude_m = 434.0\npixels = [";
  for (const double off : {-8.0, -3.0, 2.0, 7.0}) {
    const auto below = from_degrees(90.0 + 1.76 * std::sqrt(1016.0) / 60.0);
    const auto pixel = truth.lens->project(direction_from(below, from_degrees(263.0 + off)) * truth.to_world).value();
    text += fmt::format("{:.1f}, {:.1f}, ", pixel.x + noise(), pixel.y + noise());
  }
  text += "]\n";
  ASSERT_TRUE(write_text_file(folder / "sights.toml", text));
  const auto outcome =
      run(fmt::format("scene {} --picture {} --focal-percent 0.1 --out {}", (folder / "sights.toml").string(),
                      (folder / "scene.png").string(), (folder / "c.toml").string()));
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  std::printf("%s", outcome.out.c_str());
  const auto found = read_camera(ConfigTable::read_file(folder / "c.toml").value().table("scene"), "scene");
  const double off_deg = to_degrees(angle_between(found.to_world[2], truth.to_world[2]));
  std::printf("optical axis off by %.4f deg\n", off_deg);
  EXPECT_LE(off_deg, 0.02);
  EXPECT_LE(to_degrees(angle_between(found.to_world[0], truth.to_world[0])), 0.1);

  text.replace(text.find("T17:18:00Z"), 10, "T21:18:00Z");
  ASSERT_TRUE(write_text_file(folder / "sights.toml", text));
  const auto night = ended(2, run(fmt::format("scene {} --picture {} --out {}", (folder / "sights.toml").string(),
                                              (folder / "scene.png").string(), (folder / "n.toml").string())));
  EXPECT_THAT(night.err, HasSubstr("sightings[2].utc"));
  EXPECT_THAT(night.err, HasSubstr("a time at which the sun is up"));
}

TEST(CalibrateScene, ReportsAllProblemsAtOnce) {
  const auto folder = fresh_folder("calibrate-scene-wrong");
  ASSERT_TRUE(write_png(folder / "scene.png", Image<Rgb8>(64, 36, Rgb8(150))));
  const Truth truth;
  auto text = landmarks(truth, 1900.0, 99);
  const auto replace = [&](const std::string& what, const std::string& by) {
    const auto at = text.find(what);
    ASSERT_NE(at, std::string::npos) << what;
    text.replace(at, what.size(), by);
  };
  replace("model = \"pinhole\"", "model = \"pinhole\"\nzoom = 3");
  replace("latitude_deg = 46.958", "latitude_deg = -46.958");
  replace("name = 'Burg'", "nam = 'Burg'");
  ASSERT_TRUE(write_text_file(folder / "landmarks.toml", text));
  const auto outcome = ended(2, run(fmt::format("scene {} --picture /nowhere/at-all.png --out {}",
                                                (folder / "landmarks.toml").string(), (folder / "c.toml").string())));
  for (const char* part :
       {"at-all.png", "scene.lens.zoom", "landmarks[0].latitude_deg", "landmarks[4].name", "landmarks[4].nam:"})
    EXPECT_THAT(outcome.err, HasSubstr(part));
  EXPECT_FALSE(std::filesystem::exists(folder / "c.toml"));
}

}  // namespace
}  // namespace kasumi
