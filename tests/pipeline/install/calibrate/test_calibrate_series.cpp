// `kasumi calibrate sky FOLDER`: from a folder of pictures to a camera that all commands take.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/table/config_table.hpp"
#include "base/utc_text.hpp"
#include "estimator/sky/sun.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/install/calibrate/strange_series.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

const SeriesDay kDay{.times = {"2026-05-04T21:30:00Z", "2026-05-04T22:30:00Z", "2026-05-05T00:00:00Z",
                               "2026-05-05T01:30:00Z", "2026-05-05T03:00:00Z", "2026-05-05T05:00:00Z",
                               "2026-05-05T06:30:00Z", "2026-05-05T08:00:00Z"}};

// The mirrored one sees below the horizon and is tilted: its horizon is round about the zenith, and not about its axis.
StrangeCamera equisolid_camera(bool mirrored) {
  StrangeCamera camera;
  const double edge_deg = mirrored ? 92.0 : 91.0, pitch_deg = mirrored ? 87.4 : 88.5;
  const double focal = 150.0;
  camera.lens = {IdealFisheyeParameters{{243.0, 236.5}, focal, true}, from_degrees(95.0), mirrored};
  camera.circle = {{243.0, 236.5}, 2.0 * focal * std::sin(0.5 * from_degrees(edge_deg).value)};
  camera.to_world = camera_to_world(from_degrees(75.0), from_degrees(pitch_deg), from_degrees(40.0));
  camera.tone_exponent = 1.25;
  camera.rim_loss = 0.3;
  return camera;
}

TEST(CalibrateSeries, AFolderOfADayTellsTheCamera) {
  const auto skies = skies_of(kDay);
  for (const bool mirrored : {false, true}) {
    const auto folder = test_folder(mirrored ? "series-mirrored" : "series");
    const auto truth = equisolid_camera(mirrored);
    write_series(folder, kDay, skies, truth);
    const auto file = test_folder("series-calibration") / (mirrored ? "mirrored.toml" : "plain.toml");
    std::filesystem::create_directories(file.parent_path());
    std::filesystem::remove(file);
    const auto told =
        ended(0, run_kasumi(fmt::format("calibrate sky {} --lat 34.7 --lon 135.8 --altitude-m 100 --out {}",
                                        folder.string(), file.string())));
    std::printf("%s", told.out.c_str());
    EXPECT_THAT(told.out, HasSubstr(mirrored ? "pictures are mirrored\n" : "pictures are not mirrored\n"));

    const auto table = must(ConfigTable::read_file(file));
    const Camera camera = read_camera(table->table("sky"), "sky");
    read_site(table->table("site"));
    for (const double zenith_deg : {20.0, 50.0, 75.0}) {
      double worst = 0.0;
      for (int k = 0; k < 12; ++k) {
        const Direction direction = direction_from(from_degrees(zenith_deg), from_degrees(30.0 * k));
        const auto pixel = make_lens(truth.lens)->project(direction * truth.to_world);
        const auto found = pixel ? camera.direction_at(*pixel) : std::nullopt;
        worst = std::max(worst, found ? to_degrees(angle_between(*found, direction)) : 90.0);
      }
      std::printf("at %.0f deg from the zenith: off by %.2f deg at most\n", zenith_deg, worst);
      EXPECT_LT(worst, 0.8);
    }
    // Half of full scale, as the camera's own curve has it.
    const double read = camera.response.to_light(glm::dvec3(0.5)).x;
    const double exponent = std::log(Response::srgb().to_light(glm::dvec3(0.5)).x) / std::log(read);
    std::printf("tone exponent %.3f (1.25)\n", exponent);
    EXPECT_NEAR(exponent, 1.25, 0.12);
    EXPECT_FALSE(camera.mask.empty());

    // The calibration is one that other commands take.
    const auto estimate = run_kasumi(fmt::format("estimate {} --calibration {} --utc 2026-05-05T01:30:00Z --json",
                                                 (folder / "20260505_013000.png").string(), file.string()));
    EXPECT_EQ(estimate.code, 0) << estimate.out << estimate.err;
    EXPECT_THAT(estimate.out, HasSubstr("\"usable\":true"));
  }
}

TEST(CalibrateSeries, TwoSunsSayHowLittleThatIs) {
  SeriesDay day = kDay;
  day.times = {"2026-05-05T01:30:00Z", "2026-05-05T01:34:00Z"};
  const auto folder = test_folder("series-two");
  write_series(folder, day, skies_of(day), equisolid_camera(false));
  const auto file = test_folder("series-calibration") / "two.toml";
  std::filesystem::create_directories(file.parent_path());
  std::filesystem::remove(file);
  const auto told =
      run_kasumi(fmt::format("calibrate sky {} --lat 34.7 --lon 135.8 --out {}", folder.string(), file.string()));
  ASSERT_EQ(told.code, 0) << told.err;
  EXPECT_THAT(told.out, HasSubstr("2 suns: that determines the heading, and little else"));
  EXPECT_THAT(told.out, HasSubstr("undetermined: "));
}

TEST(CalibrateSeries, WhatIsMissingIsSaid) {
  const auto folder = test_folder("series-nothing");
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  const auto file = (folder / "x.toml").string();
  auto told = ended(2, run_kasumi(fmt::format("calibrate sky {} --out {}", folder.string(), file)));
  EXPECT_THAT(told.err, HasSubstr("expected --lat and --lon"));
  told = run_kasumi(fmt::format("calibrate sky {} --lat 1 --lon 2 --out {}", folder.string(), file));
  EXPECT_EQ(told.code, 2);
  EXPECT_THAT(told.err, HasSubstr("a folder without any picture"));
  std::filesystem::copy_file(source_folder() / "fixtures/demo/sky/frame-000001.jpg", folder / "a.jpg");
  told = run_kasumi(fmt::format("calibrate sky {} --lat 1 --lon 2 --out {}", folder.string(), file));
  EXPECT_EQ(told.code, 2);
  EXPECT_THAT(told.err, HasSubstr("1 without a time: expected times in their names"));
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace kasumi
