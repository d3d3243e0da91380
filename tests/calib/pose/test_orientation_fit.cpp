// The sky camera's orientation from the sun's path across the sky in closed form, without an ephemeris.
#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "calib/pose/orientation_fit.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-53;
}
double normal(std::mt19937_64& random) {
  return std::sqrt(-2.0 * std::log(1.0 - uniform(random))) * std::cos(2.0 * kPi * uniform(random));
}

// The sun of a day of given declination, seen from 47 deg north, some hours after noon.
Direction sun_at(double hours, double declination_deg) {
  const double latitude = from_degrees(47.0).value, d = from_degrees(declination_deg).value;
  const double h = from_degrees(15.0 * hours).value;
  return {-std::cos(d) * std::sin(h), std::sin(d) * std::cos(latitude) - std::cos(d) * std::sin(latitude) * std::cos(h),
          std::sin(d) * std::sin(latitude) + std::cos(d) * std::cos(latitude) * std::cos(h)};
}

// A fisheye of 1080 px on a roof, mounted slightly askew, its focal length 1.2 % above its data sheet and its axis off
// the circle's centre.
struct Roof {
  LensDescription lens{IdealFisheyeParameters{{541.8, 537.9}, 337.0 * 1.012, false}, from_degrees(95.0)};
  glm::dmat3 to_world = camera_to_world(from_degrees(63.0), from_degrees(87.7), from_degrees(141.0));

  OrientationPrior prior() const {
    OrientationPrior prior;
    prior.lens = {IdealFisheyeParameters{{542.1, 537.6}, 337.0, false}, from_degrees(95.0)};
    prior.centre_sigma_px = glm::dvec2(0.5);
    prior.scale_sigma = 0.03;
    prior.to_world = camera_to_world(from_degrees(0.0), from_degrees(90.0), from_degrees(0.0));
    return prior;
  }
  // As accurate as kasumi calibrate lens makes it: centre to a tenth of a pixel, focal length to a thousandth.
  OrientationPrior known_lens() const {
    OrientationPrior prior = this->prior();
    prior.lens = moved(lens, centre_of(lens) + glm::dvec2{0.07, -0.05}, 1.0006);
    prior.centre_sigma_px = glm::dvec2(0.1);
    prior.scale_sigma = 0.001;
    return prior;
  }
  SunSight sight(const Direction& sun, double noise_px, std::mt19937_64& random) const {
    const auto at = make_lens(lens)->project(sun * to_world).value();
    const double x = normal(random), y = normal(random);
    return {sun, at + noise_px * glm::dvec2{x, y}};
  }
};

double error_deg(const glm::dmat3& a, const glm::dmat3& b) {
  const glm::dmat3 between = a * glm::transpose(b);
  const double cosine = 0.5 * (between[0][0] + between[1][1] + between[2][2] - 1.0);
  return to_degrees({std::acos(std::clamp(cosine, -1.0, 1.0))});
}

// A picture every 15 s. Clouds pass in blocks of 6 minutes and hide the sun; some of the remaining sightings are false:
// a cloud's bright edge nearby, or the sun's reflection on the dome's opposite side.
std::vector<SunSight> track(const Roof& roof, double from_h, double to_h, double declination_deg, double cloud_cover,
                            double noise_px, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<SunSight> sights;
  bool cloudy = false;
  int step = 0;
  for (double hours = from_h; hours < to_h; hours += 15.0 / 3600.0, ++step) {
    if (step % 24 == 0) cloudy = uniform(random) < cloud_cover;
    auto sight = roof.sight(sun_at(hours, declination_deg), noise_px, random);
    if (cloudy) {
      const double kind = uniform(random);
      if (kind > 0.15) continue;
      if (kind > 0.07)
        sight.pixel += glm::dvec2{22.0, 10.0 + 6.0 * kind};
      else
        sight.pixel = 2.0 * centre_of(roof.lens) - 0.8 * sight.pixel;
    }
    sights.push_back(sight);
  }
  return sights;
}

struct Hours {
  double from_h, declination_deg;
  std::uint64_t seed;
};
const std::vector<Hours> kDays{{-1.0, 10.0, 1}, {-4.0, 20.0, 2}, {0.5, 0.0, 3}, {-1.5, -15.0, 4}};

TEST(OrientationFit, ThreeHoursOfSunThroughCloudsFixItForAKnownLens) {
  const Roof roof;
  for (const auto& day : kDays) {
    const auto sights = track(roof, day.from_h, day.from_h + 3.0, day.declination_deg, 0.4, 0.5, day.seed);
    const auto found = must(fit_orientation(sights, roof.known_lens()));
    std::printf("%zu sights: off by %.4f deg; sigma %.4f %.4f %.4f deg\n", sights.size(),
                error_deg(found->to_world, roof.to_world), to_degrees(found->sigma.azimuth),
                to_degrees(found->sigma.tilt_east), to_degrees(found->sigma.tilt_north));
    EXPECT_LE(error_deg(found->to_world, roof.to_world), 0.05);
    EXPECT_LE(std::abs(focal_px_of(found->lens) / focal_px_of(roof.lens) - 1.0), 0.003);
    EXPECT_NEAR(found->rms_px, 0.5 * std::sqrt(2.0), 0.05);
  }
}

// What a data sheet leaves open: a tilt and a shift of the lens look nearly the same, so the axis is only as certain as
// the circle's centre, but where the sun passed, the pixels' directions are right.
TEST(OrientationFit, ThreeHoursOfSunGiveTheFocalLengthOfALensFromADataSheet) {
  const Roof roof;
  for (const auto& day : kDays) {
    const auto sights = track(roof, day.from_h, day.from_h + 3.0, day.declination_deg, 0.4, 0.5, day.seed);
    const auto found = must(fit_orientation(sights, roof.prior()));
    EXPECT_LE(std::abs(focal_px_of(found->lens) / focal_px_of(roof.lens) - 1.0), 0.003);
    EXPECT_LE(glm::distance(centre_of(found->lens), centre_of(roof.lens)), 0.003 * 540.0);
    EXPECT_LE(error_deg(found->to_world, roof.to_world), 0.3);
    EXPECT_THAT(found->undetermined, testing::Contains(HasSubstr("centre of the lens")));
    for (double hours = day.from_h; hours <= day.from_h + 3.0; hours += 0.5) {
      const auto sun = sun_at(hours, day.declination_deg);
      const auto pixel = make_lens(roof.lens)->project(sun * roof.to_world).value();
      const auto estimated = found->to_world * make_lens(found->lens)->unproject(pixel).value();
      EXPECT_LE(to_degrees(angle_between(estimated, sun)), 0.05) << hours;
    }
  }
}

TEST(OrientationFit, ThreePicturesOfADayFixItForAKnownLens) {
  const Roof roof;
  const auto prior = roof.known_lens();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    std::mt19937_64 random(seed);
    std::vector<SunSight> sights;
    for (const double hours : {-3.0, 0.0, 3.0}) sights.push_back(roof.sight(sun_at(hours, 5.0), 0.5, random));
    const auto found = must(fit_orientation(sights, prior));
    EXPECT_LE(error_deg(found->to_world, roof.to_world), 0.3);
    std::printf("off by %.3f deg, sigma azimuth %.3f deg\n", error_deg(found->to_world, roof.to_world),
                to_degrees(found->sigma.azimuth));
  }
}

TEST(OrientationFit, ItsErrorsAreAsReported) {
  const Roof roof;
  double azimuth = 0.0, scale = 0.0;
  constexpr int kRepeats = 12;
  for (int day = 0; day < kRepeats; ++day) {
    const auto found =
        fit_orientation(track(roof, -2.0, 2.0, 10.0, 0.3, 0.5, 100 + static_cast<std::uint64_t>(day)), roof.prior());
    ASSERT_TRUE(found);
    const glm::dmat3 by = found->to_world * glm::transpose(roof.to_world);
    azimuth += std::pow(by[0][1] / found->sigma.azimuth.value, 2.0) / kRepeats;
    scale += std::pow(std::log(focal_px_of(found->lens) / focal_px_of(roof.lens)) / found->sigma.scale, 2.0) / kRepeats;
  }
  // The mean of 12 squared standard normal numbers lies in .25 .. 2.3 in 99 % of all cases.
  EXPECT_GT(azimuth, 0.05);
  EXPECT_LT(azimuth, 2.3);
  EXPECT_GT(scale, 0.05);
  EXPECT_LT(scale, 2.3);
}

TEST(OrientationFit, OnePictureFixesTheAzimuthOnlyAndSaysSo) {
  Roof roof;
  roof.to_world = camera_to_world(from_degrees(63.0), from_degrees(90.0), from_degrees(0.0));
  auto prior = roof.prior();
  prior.lens = roof.lens;
  std::mt19937_64 random(1);
  const std::vector sights{roof.sight(sun_at(-1.0, 10.0), 0.0, random)};
  const auto found = must(fit_orientation(sights, prior));
  EXPECT_LE(error_deg(found->to_world, roof.to_world), 1e-6);
  ASSERT_EQ(found->undetermined.size(), 1u);
  EXPECT_THAT(found->undetermined[0], HasSubstr("azimuth only"));
  EXPECT_EQ(found->sigma.tilt_east, prior.level_sigma);
  EXPECT_GT(found->sigma.azimuth, from_degrees(1.0));  // a tilt across the sun's path would look the same
}

TEST(OrientationFit, AShortTrackReportsWhatItDoesNotFix) {
  const Roof roof;
  const auto found = must(fit_orientation(track(roof, -0.2, 0.4, 10.0, 0.0, 0.5, 5), roof.prior()));
  EXPECT_FALSE(found->undetermined.empty());
  EXPECT_LE(error_deg(found->to_world, roof.to_world), 4.0);
}

TEST(OrientationFit, SightingsThatDoNotFollowTheSunAreRefused) {
  EXPECT_FALSE(fit_orientation({}, Roof().prior()));
  std::mt19937_64 random(9);
  std::vector<SunSight> sights;
  for (double hours = -2.0; hours < 2.0; hours += 0.5)
    sights.push_back({sun_at(hours, 10.0), {300.0 + 400.0 * uniform(random), 300.0 + 400.0 * uniform(random)}});
  const auto found = fit_orientation(sights, Roof().prior());
  if (found) {
    EXPECT_LT(std::count(found->used.begin(), found->used.end(), true), 5);
  } else {
    EXPECT_THAT(found.error().message, HasSubstr("do not agree"));
  }
}

}  // namespace
}  // namespace kasumi
