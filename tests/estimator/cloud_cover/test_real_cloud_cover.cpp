// Cloud fraction and sky class of strangers' photographs with hand-made labels; see the shared data's README.
#include <cmath>
#include <map>
#include <string>

#include <gtest/gtest.h>

#include "estimator/cloud_cover/cloud_cover.hpp"
#include "tests/estimator/sky_camera/labelled_skies.hpp"

namespace kasumi {
namespace {

CloudCover cover_of(const test::LabelledSky& sky) {
  std::optional<SunDirection> sun;
  if (sky.sun_px) sun = sky.camera.direction_at(*sky.sun_px);
  return cloud_cover(*sky_picture(view_of(sky.pixels), sky.camera), sky.camera, sun);
}

struct Tally {
  int pictures = 0;
  double sum = 0.0;
  void add(double value) { ++pictures, sum += value; }
  double mean() const { return sum / std::max(1, pictures); }
};

TEST(RealCloudCover, StrangersPicturesHaveTheirCloudFractionAndClass) {
  const auto skies = test::labelled_skies();
  if (skies.empty()) GTEST_SKIP() << "no shared data: sky/real";
  Tally answered, error, covered;
  std::map<std::string, Tally> right;
  for (const auto& sky : skies) {
    const CloudCover cover = cover_of(sky);
    if (sky.sky == "unknown") {
      EXPECT_FALSE(cover.fraction) << sky.id;
    }
    if (sky.sky != "unknown" && sky.sky != "none") right[sky.name].add(name_of(cover.sky) == sky.sky);
    if (!sky.cloud) continue;
    answered.add(cover.fraction.has_value());
    if (!cover.fraction) continue;
    const double off = std::abs(*cover.fraction - *sky.cloud);
    error.add(off);
    covered.add(off <= 2.0 * cover.sigma);
  }
  Tally classes;
  for (const auto& [camera, tally] : right) {
    std::printf("%-10s sky class right: %.0f %% of %d\n", camera.c_str(), 100.0 * tally.mean(), tally.pictures);
    classes.add(tally.mean());
  }
  std::printf(
      "fraction answered %.0f %% (goal 90), off by %.1f %% (10), within 2 sigma %.0f %% (95); classes right %.0f %% "
      "(85)\n",
      100.0 * answered.mean(), 100.0 * error.mean(), 100.0 * covered.mean(), 100.0 * classes.mean());
  EXPECT_GE(answered.mean(), 0.95);
  EXPECT_LE(error.mean(), 0.06);
  EXPECT_GE(covered.mean(), 0.90);
  EXPECT_GE(classes.mean(), 0.70);
  EXPECT_GE(right["wsiseg"].mean(), 0.75);
}

}  // namespace
}  // namespace kasumi
