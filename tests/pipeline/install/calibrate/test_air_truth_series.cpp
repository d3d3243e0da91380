// How exact `kasumi calibrate sky FOLDER` is: a day's twenty pictures by cameras that are drawn at random. The skies are
// the generator's, seen through another lens: the program's geometry is tried, not the sky.
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "base/statistics.hpp"
#include "base/table/config_table.hpp"
#include "calib/camera.hpp"
#include "tests/figures.hpp"
#include "tests/pipeline/install/calibrate/strange_series.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

SeriesDay long_day() {
  SeriesDay day;
  // From the sun 10 deg high to 10 deg high again.
  for (int k = 0; k < 20; ++k) {
    const int minutes = 21 * 60 + 15 + 35 * k;
    day.times.push_back(
        fmt::format("2026-05-{:02}T{:02}:{:02}:00Z", 4 + minutes / 1440, minutes / 60 % 24, minutes % 60));
  }
  return day;
}

StrangeCamera drawn_camera(std::mt19937_64& random) {
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  std::normal_distribution<double> normal;
  StrangeCamera camera;
  const glm::dvec2 centre{240.0 + 6.0 * share(random), 238.0 + 6.0 * share(random)};
  const double radius = 215.0 + 8.0 * share(random), edge = from_degrees(91.0 + 1.5 * share(random)).value;
  const bool equisolid = share(random) > 0.0, mirrored = share(random) > 0.4;
  const double focal = radius / (equisolid ? 2.0 * std::sin(0.5 * edge) : edge);
  camera.lens = {IdealFisheyeParameters{centre, focal, equisolid}, from_degrees(96.0), mirrored};
  camera.circle = {centre, radius};
  camera.to_world =
      camera_to_world(from_degrees(180.0 * share(random)), from_degrees(90.0 - std::abs(1.2 * normal(random))),
                      from_degrees(180.0 * share(random)));
  camera.tone_exponent = std::exp(0.2 * normal(random));
  camera.rim_loss = 0.2 + 0.2 * share(random);
  return camera;
}

struct Errors {
  double heading_deg = 180.0, horizon_deg = 90.0, exponent = 9.0;
};

Errors errors_of(const Camera& found, const StrangeCamera& truth) {
  Errors errors{0.0, 0.0, 0.0};
  const auto lens = make_lens(truth.lens);
  double turn = 0.0;
  int seen = 0;
  for (int k = 0; k < 24; ++k) {
    const auto off = [&](double zenith_deg, double& azimuth, double& zenith) {
      const Direction direction = direction_from(from_degrees(zenith_deg), from_degrees(15.0 * k));
      const auto pixel = lens->project(direction * truth.to_world);
      const auto at = pixel ? found.direction_at(*pixel) : std::nullopt;
      if (!at) return false;
      azimuth = std::remainder(to_degrees(azimuth_angle(*at) - azimuth_angle(direction)), 360.0);
      zenith = to_degrees(zenith_angle(*at) - zenith_angle(direction));
      return true;
    };
    double azimuth = 0.0, zenith = 0.0;
    if (off(60.0, azimuth, zenith)) turn += azimuth, ++seen;
    // Where the fitted lens ends before the horizon it is off by as much as is missing.
    errors.horizon_deg = std::max(errors.horizon_deg, off(88.0, azimuth, zenith) ? std::abs(zenith) : 2.0);
  }
  errors.heading_deg = std::abs(turn / std::max(1, seen));
  const double read = found.response.to_light(glm::dvec3(0.5)).x;
  errors.exponent =
      std::abs(std::log(Response::srgb().to_light(glm::dvec3(0.5)).x) / std::log(read) - truth.tone_exponent);
  return errors;
}

TEST(AirTruthSeries, TwentyPicturesTellTheCamera) {
  const int cameras = figure_cases<int>("cameras", {4}, {25}).front();
  const SeriesDay day = long_day();
  const auto skies = skies_of(day);
  std::mt19937_64 random(11);
  const auto folder = test_folder("series-truth"), file = test_folder("series-truth.toml");
  int heading = 0, horizon = 0, exponent = 0, mirror = 0;
  std::vector<double> headings, horizons, exponents;
  for (int n = 0; n < cameras; ++n) {
    const StrangeCamera truth = drawn_camera(random);
    write_series(folder, day, skies, truth);
    std::filesystem::remove(file);
    const auto told =
        run_kasumi(fmt::format("calibrate sky {} --lat {} --lon {} --altitude-m {} --out {}", folder.string(),
                               day.site.latitude_deg, day.site.longitude_deg, day.site.altitude_m, file.string()));
    ASSERT_EQ(told.code, 0) << told.err;
    const auto table = ConfigTable::read_file(file);
    ASSERT_TRUE(table) << table.error().message;
    const auto errors = errors_of(read_camera(table->table("sky"), "sky"), truth);
    const bool right = (told.out.find("pictures are mirrored\n") != std::string::npos) == truth.lens.mirrored;
    fmt::print("{}: heading off {:.2f} deg, horizon {:.2f} deg, exponent {:.3f} of {:.3f}, mirror {}\n", n,
               errors.heading_deg, errors.horizon_deg, errors.exponent, truth.tone_exponent, right ? "right" : "WRONG");
    heading += errors.heading_deg <= 0.3;
    horizon += errors.horizon_deg <= 0.3;
    exponent += errors.exponent <= 0.05;
    mirror += right;
    headings.push_back(errors.heading_deg);
    horizons.push_back(errors.horizon_deg);
    exponents.push_back(errors.exponent);
  }
  const auto row = [&](const char* what, int good, double middle, int decimals, const char* goal) {
    const auto found = fmt::format("{} of {}", good, cameras);
    fmt::print("{}: {}, median {:.3f} (goal {})\n", what, found, middle, goal);
    figure_row("series", {what, found, goal, figure_text(middle, decimals)});
  };
  row("heading within .3 deg", heading, median(headings), 2, ">= 95 %");
  row("horizon within .3 deg all around", horizon, median(horizons), 2, ">= 95 %");
  row("tone exponent within .05", exponent, median(exponents), 3, ">= 95 %");
  row("mirrored or not", mirror, 0.0, 0, "all");
  EXPECT_EQ(mirror, cameras);
  EXPECT_GE(heading, 0.95 * cameras);
  EXPECT_LT(median(horizons), 0.7);
  EXPECT_LT(median(exponents), 0.1);
}

}  // namespace
}  // namespace kasumi
