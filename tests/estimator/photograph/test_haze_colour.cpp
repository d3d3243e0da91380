// The exponent of a photograph's haze, against scenes drawn by Koschmieder's law in closed form.
#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "estimator/photograph/haze_colour.hpp"
#include "estimator/photograph/other_air.hpp"
#include "tests/estimator/photograph/hazy_land.hpp"

namespace kasumi {
namespace {

Camera camera_of_narrow_channels() {
  auto camera = plain_camera(kLandWidth, kLandHeight, from_degrees(50.0), Radians{0.0});
  camera.colour_space = Camera::ColourSpace::sensor;
  camera.sensitivity.first_nm = 380.0;
  camera.sensitivity.step_nm = 5.0;
  camera.sensitivity.samples.assign(81, glm::dvec3(0.0));
  for (int c = 0; c < 3; ++c)
    camera.sensitivity.samples[static_cast<std::size_t>((kLandWavelengths_nm[c] - 380.0) / 5.0)][c] = 1.0;
  return camera;
}

HazeColour found_in(const HazyLand& land) {
  const auto camera = camera_of_narrow_channels();
  const auto picture = hazy_picture(camera, drawn(land));
  EXPECT_TRUE(picture.from_sky);
  return haze_colour_of(camera, picture);
}

TEST(HazeColour, FindsTheExponentOfHazeWithinItsSigma) {
  double worst = 0.0, sum = 0.0;
  int scenes = 0, told = 0;
  for (const double exponent : {-0.2, 0.0, 0.5, 1.3, 2.0})
    for (const double green_per_km : {0.5, 1.0})
      for (const auto& infinity :
           {glm::dvec3(0.62, 0.62, 0.60), glm::dvec3(0.45, 0.55, 0.75), glm::dvec3(0.6, 0.5, 0.35)}) {
        const auto found = found_in({.exponent = exponent,
                                     .green_per_km = green_per_km,
                                     .infinity = infinity,
                                     .seed = static_cast<unsigned>(++scenes)});
        const double off = found.exponent - exponent;
        fmt::print("exponent {:4.1f}, {:.1f} per km, airlight {:.2f} {:.2f} {:.2f}: {:5.2f} +- {:.2f} {}\n", exponent,
                   green_per_km, infinity.r, infinity.g, infinity.b, found.exponent, found.sigma, found.reason);
        worst = std::max(worst, std::abs(off / found.sigma));
        sum += off * off / (found.sigma * found.sigma);
        if (!found.told) continue;
        ++told;
        // Where the farthest land keeps a twentieth of its light it passes for sky, and coloured haze looks greyer.
        EXPECT_NEAR(off, 0.0, green_per_km < 1.0 || exponent < 1.0 ? 0.7 : 0.9);
        if (exponent == 0.0) {
          EXPECT_LT(std::abs(found.exponent), 0.15) << "grey must stay grey";
        }
      }
  fmt::print("{} of {} told; errors over sigma: {:.2f} rms, {:.2f} at worst\n", told, scenes, std::sqrt(sum / scenes),
             worst);
  EXPECT_GE(told, 28);
  EXPECT_LT(worst, 2.2);
  EXPECT_LT(std::sqrt(sum / scenes), 1.1);
}

TEST(HazeColour, IsNotToldByClearAir) {
  const auto found = found_in({.exponent = 1.3, .green_per_km = 0.02});
  EXPECT_FALSE(found.told);
  EXPECT_FALSE(found.reason.empty());
}
TEST(HazeColour, IsNotToldByLandAtOneDistance) {
  const auto found = found_in({.exponent = 1.3, .green_per_km = 1.0, .nearest_m = 1000.0, .farthest_m = 1100.0});
  EXPECT_FALSE(found.told) << found.exponent << " +- " << found.sigma;
}
TEST(HazeColour, IsNotToldByLandThatChangesItsColour) {
  const auto found = found_in({.exponent = 0.0, .green_per_km = 0.3, .land_changes = true});
  EXPECT_TRUE(!found.told || std::abs(found.exponent) < 3.0 * found.sigma)
      << found.exponent << " +- " << found.sigma << " " << found.reason;
}
TEST(HazeColour, IsNotToldByFogThatHidesAll) {
  const auto found = found_in({.exponent = 0.0, .green_per_km = 20.0});
  EXPECT_FALSE(found.told);
}

// Rows 300 to 320 are 640 m away; a sixth of their light is the land's own.
TEST(HazeColour, TellsTheContrastOfAPart) {
  for (const double green_per_km : {0.3, 1.0, 2.0}) {
    const auto camera = camera_of_narrow_channels();
    const auto picture = hazy_picture(camera, drawn({.exponent = 1.3, .green_per_km = green_per_km}));
    const auto part = part_contrast(picture, {100, 300, 300, 20});
    ASSERT_TRUE(part);
    const double left = std::exp(-1e-3 * green_per_km * distance_of_row({}, 310));
    const double sigma = std::hypot(0.06 * left + 0.01, part->infinity_sigma * (1.0 - part->contrast.g));
    fmt::print("{} per km: contrast {:.3f}, spread {:.3f} where {:.3f} is left; by the sky: {}\n", green_per_km,
               part->contrast.g, part->spread, left, picture.from_sky);
    EXPECT_NEAR(part->contrast.g, 0.95 * left, 2.0 * sigma) << "its dark materials, at " << green_per_km;
    EXPECT_LT(part->spread, 0.01) << "they are alike";
    EXPECT_GT(part->infinity_sigma, 0.04) << "no sky is beside it";
  }
  const auto picture = hazy_picture(camera_of_narrow_channels(), drawn({}));
  constexpr int kMost = std::numeric_limits<int>::max();
  EXPECT_FALSE(part_contrast(picture, {2000, 300, 10, 10}));
  EXPECT_FALSE(part_contrast(picture, {100, 300, -5, 10}));
  EXPECT_FALSE(part_contrast(picture, {kMost, kMost, kMost, kMost}));
  EXPECT_TRUE(part_contrast(picture, {0, 300, kMost, kMost})) << "as much of it as there is";
}

}  // namespace
}  // namespace kasumi
