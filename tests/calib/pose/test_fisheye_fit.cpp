// Cameras of which nothing is known but their image circle, from the places of the sun in their pictures; what is drawn
// here is geometry alone.
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "base/statistics.hpp"
#include "calib/pose/fisheye_fit.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

struct Projection {
  const char* name;
  std::function<double(double)> radius;  // over the focal length, of the angle off the axis
};
const std::vector<Projection> kProjections{{"equidistant", [](double t) { return t; }},
                                           {"equisolid", [](double t) { return 2.0 * std::sin(0.5 * t); }},
                                           {"stereographic", [](double t) { return 2.0 * std::tan(0.5 * t); }},
                                           {"orthographic", [](double t) { return std::sin(t); }}};

// A camera as it really is, and the suns of a day, or of a few hours, in its pictures.
struct Drawn {
  Projection projection;
  double focal_px, edge_deg;
  glm::dvec2 centre;
  glm::dmat3 to_world;
  bool mirrored;

  glm::dvec2 pixel_of(const Direction& direction) const {
    glm::dvec3 ray = direction * to_world;
    if (mirrored) ray.x = -ray.x;
    const double off = std::hypot(ray.x, ray.y);
    return centre + focal_px * projection.radius(std::atan2(off, ray.z)) / off * glm::dvec2{ray.x, ray.y};
  }
  ImageCircle circle() const { return {centre, focal_px * projection.radius(from_degrees(edge_deg).value), 0.5}; }
};

Drawn drawn(std::mt19937_64& random, const Projection& projection) {
  std::uniform_real_distribution<double> share(-1.0, 1.0);
  std::normal_distribution<double> normal;
  const bool ends = std::string_view(projection.name) == "orthographic";
  Drawn camera{projection,
               160.0 + 60.0 * share(random),
               ends ? 89.5 : 91.0 + 3.0 * share(random),
               {300.0 + 20.0 * share(random), 290.0 + 20.0 * share(random)},
               {},
               share(random) > 0.5};
  camera.to_world =
      camera_to_world(from_degrees(180.0 * share(random)), from_degrees(90.0 - std::abs(2.0 * normal(random))),
                      from_degrees(180.0 * share(random)));
  return camera;
}

// Suns along a day at 40 deg of latitude, half an hour apart or as given.
std::vector<SunSight> suns_of(const Drawn& camera, int count, double hours, std::mt19937_64& random,
                              double sigma_px = 0.5) {
  std::normal_distribution<double> normal(0.0, sigma_px);
  const double latitude = from_degrees(40.0).value, declination = from_degrees(15.0).value;
  std::vector<SunSight> sights;
  for (int k = 0; k < count; ++k) {
    const double hour = from_degrees(15.0 * hours * ((k + 0.5) / count - 0.5)).value;
    const Direction sun{
        -std::cos(declination) * std::sin(hour),
        std::sin(declination) * std::cos(latitude) - std::cos(declination) * std::cos(hour) * std::sin(latitude),
        std::sin(declination) * std::sin(latitude) + std::cos(declination) * std::cos(hour) * std::cos(latitude)};
    sights.push_back({sun, camera.pixel_of(sun) + glm::dvec2{normal(random), normal(random)}});
  }
  return sights;
}

FisheyePrior prior_of(const Drawn& camera, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  FisheyePrior prior;
  prior.circle = camera.circle();
  prior.circle.centre += 0.7 * glm::dvec2{normal(random), normal(random)};
  prior.circle.radius_px += 0.5 * normal(random);
  prior.sun_sigma_px = 0.5;
  return prior;
}

// How far a direction is from where the fit has it, at most over the horizon, or over where the suns are.
double worst_deg(const Drawn& camera, const FisheyeFit& fit, Radians zenith) {
  auto lens = fit.orientation.lens;
  lens.largest_angle = from_degrees(120.0);
  const auto made = make_lens(lens);
  double worst = 0.0;
  for (int k = 0; k < 24; ++k) {
    const Direction direction = direction_from(zenith, from_degrees(15.0 * k));
    const auto ray = made->unproject(camera.pixel_of(direction));
    worst = std::max(worst, ray ? to_degrees(angle_between(fit.orientation.to_world * *ray, direction)) : 90.0);
  }
  return worst;
}

TEST(FisheyeFit, TwentySunsOfADayTellProjectionHeadingAndMirror) {
  std::mt19937_64 random(7);
  int all = 0, mirrors = 0, near = 0, at_horizon = 0;
  std::vector<double> horizons;
  for (int n = 0; n < 4; ++n)
    for (const Projection& projection : kProjections) {
      const Drawn camera = drawn(random, projection);
      const auto suns = suns_of(camera, 20, 12.0, random);
      const auto fit = must(fit_fisheye(suns, prior_of(camera, random)));
      ++all;
      mirrors += fit->mirror_known && fit->mirrored == camera.mirrored ? 1 : 0;
      near += worst_deg(camera, *fit, from_degrees(45.0)) < 0.5 ? 1 : 0;
      // At 90 deg all of an orthographic lens' directions share the rim.
      const bool ends = std::string_view(projection.name) == "orthographic";
      horizons.push_back(worst_deg(camera, *fit, from_degrees(ends ? 70.0 : 85.0)));
      at_horizon += horizons.back() < 1.0 ? 1 : 0;
    }
  std::printf(
      "of %d cameras: mirror right %d, within .5 deg at 45 deg %d, within 1 deg at the horizon %d (median %.2f)\n", all,
      mirrors, near, at_horizon, median(horizons));
  EXPECT_EQ(mirrors, all);
  EXPECT_GE(near, 95 * all / 100);
  EXPECT_GE(at_horizon, 90 * all / 100);
}

TEST(FisheyeFit, FalseSunsAreLeftOut) {
  std::mt19937_64 random(3);
  const Drawn camera = drawn(random, kProjections[1]);
  auto suns = suns_of(camera, 16, 10.0, random);
  for (int k = 0; k < 3; ++k) suns[static_cast<std::size_t>(5 * k + 2)].pixel += glm::dvec2{60.0 + 30.0 * k, -45.0};
  const auto fit = must(fit_fisheye(suns, prior_of(camera, random)));
  EXPECT_EQ(std::count(fit->orientation.used.begin(), fit->orientation.used.end(), false), 3);
  EXPECT_EQ(fit->mirrored, camera.mirrored);
}

TEST(FisheyeFit, SunsAtOnePlaceTellTheHeadingAndSayThatItIsAll) {
  std::mt19937_64 random(5);
  const Drawn camera = drawn(random, kProjections[0]);
  const auto suns = suns_of(camera, 2, 0.1, random);
  const auto fit = must(fit_fisheye(suns, prior_of(camera, random)));
  EXPECT_FALSE(fit->mirror_known);
  EXPECT_EQ(fit->projection, "equidistant");
  EXPECT_FALSE(fit->orientation.undetermined.empty());
  EXPECT_FALSE(fit_fisheye({}, prior_of(camera, random)));
}

TEST(FisheyeFit, ALensForStoredPixelsSqueezesColumns) {
  const LensDescription round{IdealFisheyeParameters{{300.0, 290.0}, 150.0, true}, from_degrees(95.0), true};
  const auto squeezed = make_lens(in_stored_pixels(round, 1.067)), square = make_lens(round);
  for (const glm::dvec3 ray : {glm::dvec3{0.3, 0.2, 0.9}, glm::dvec3{-0.9, 0.1, 0.2}}) {
    const auto a = *squeezed->project(ray), b = *square->project(ray);
    EXPECT_NEAR(1.067 * a.x, b.x, 0.01);
    EXPECT_NEAR(a.y, b.y, 0.01);
  }
}

}  // namespace
}  // namespace kasumi
