// Clouds asked of the sky as it is, on skies that are not the model's.
#include <cmath>

#include <gtest/gtest.h>

#include "estimator/turbidity/cloud_mask.hpp"
#include "estimator/turbidity/smooth_aureole.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi {
namespace {

constexpr int kSide = 300;

// A sky's picture and what the model's mask says of it, or what a test says instead.
struct Seen {
  explicit Seen(const test::SyntheticSky& description)
      : camera(test::upward_camera(kSide)),
        rendered(test::render(description, camera)),
        picture(*sky_picture(rendered.encoded, 1.0 / 255.0, camera)),
        geometry(sky_geometry(camera, picture)),
        light(sky_light(picture, geometry, rendered.sun, {})) {}
  SmoothAureole own() const { return smooth_aureole(picture, geometry, camera, light.use, rendered.sun); }
  // Share of the solid angle that `which` selects and that is cloud in `use`.
  template <class Which>
  double cloud(const Image<PixelUse>& use, const Which& which) const {
    double cloud = 0.0, all = 0.0;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        if (!which(x, y)) continue;
        const auto angle = static_cast<double>(geometry.solid_angle.at(x, y));
        all += angle;
        if (use.at(x, y) == PixelUse::cloud) cloud += angle;
      }
    return cloud / all;
  }
  Camera camera;
  test::RenderedSky rendered;
  SkyPicture picture;
  ElementGeometry geometry;
  ElementLight light;
};

// Air whose aureole is narrower and brighter than any turbidity's. XYZ, kcd/m2.
glm::dvec3 sharp_aureole(const Direction& view) {
  const Direction sun = direction_from(from_degrees(58.4), from_degrees(-179.4));
  const double gamma = angle_between(view, sun).value;
  const double molecules = 2.0 * (1.0 + std::pow(std::cos(gamma), 2)) / (view.z + 0.25);
  const double aerosol = 16.0 * std::exp(-6.0 * gamma) / (view.z + 0.25);
  return molecules * glm::dvec3{0.75, 0.85, 1.5} + aerosol * glm::dvec3{0.95, 1.0, 1.05};
}

TEST(SmoothAureole, AnAureoleThatDiffersFromTheModelsIsNoCloud) {
  Seen seen({.clear = sharp_aureole});
  const auto around_sun = [&](int x, int y) {
    const double gamma = angle_between(glm::dvec3(seen.geometry.direction.at(x, y)), seen.rendered.sun).value;
    return seen.light.use.at(x, y) != PixelUse::outside && gamma > from_degrees(11.0).value &&
           gamma < from_degrees(35.0).value;
  };
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      if (around_sun(x, y) && seen.light.use.at(x, y) == PixelUse::clear) seen.light.use.at(x, y) = PixelUse::cloud;
  ASSERT_GT(seen.cloud(seen.light.use, around_sun), 0.9);
  EXPECT_LT(seen.cloud(seen.own().use, around_sun), 0.01);
}

TEST(SmoothAureole, CloudsStayClouds) {
  for (const double cover : {0.1, 0.3, 0.5})
    for (const std::uint64_t seed : {11u, 12u}) {
      Seen seen({.cloud_cover = cover, .cloud_seed = seed, .clear = sharp_aureole});
      mask_clouds(seen.light, seen.geometry, seen.rendered.sun);
      const auto in_cloud = [&](int x, int y) { return seen.rendered.cloud.at(x, y) != 0; };
      EXPECT_GT(seen.cloud(seen.own().use, in_cloud), 0.97 * seen.cloud(seen.light.use, in_cloud))
          << "cover " << cover << ", seed " << seed;
    }
}

TEST(SmoothAureole, WithoutTheDiscTheAureoleTellsThatTheSunShines) {
  EXPECT_GT(Seen({.sun_disc = false}).own().uncovered_sun, 0.95);
  EXPECT_GT(Seen({.sun_disc = false, .clear = sharp_aureole}).own().uncovered_sun, 0.95);
}

TEST(SmoothAureole, ASmoothGreySkyDoesNot) {
  for (const test::Weather weather : {test::Weather::overcast, test::Weather::fog})
    EXPECT_EQ(Seen({.weather = weather}).own().uncovered_sun, 0.0);
}

TEST(SmoothAureole, ACloudBeforeTheSunTakesIt) {
  Seen seen(
      {.sun_disc = false, .clear = [](const Direction& view) {
         const Direction cloud = direction_from(from_degrees(57.0), from_degrees(-178.0));
         const double inside = angle_between(view, cloud).value / from_degrees(7.0).value;
         return inside < 1.0 ? glm::dvec3{9.5, 10.0, 10.9} * (0.8 + 0.2 * std::cos(9.0 * inside)) : sharp_aureole(view);
       }});
  EXPECT_EQ(seen.own().uncovered_sun, 0.0);
}

}  // namespace
}  // namespace kasumi
