#include <gtest/gtest.h>

#include <cmath>

#include <glm/exponential.hpp>

#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/dome.hpp"
#include "estimator/sky_fit/reading_patches.hpp"
#include "estimator/sky_fit/sky_family.hpp"
#include "estimator/sky_fit/sky_fit.hpp"

namespace kasumi {
namespace {

const SunDirection kFitSun = direction_from(from_degrees(52.0), from_degrees(120.0));

std::vector<SkyReading> readings_over(const RadianceField& light, int many = 250) {
  std::vector<SkyReading> readings;
  for (int i = 0; i < many; ++i) {
    const Direction direction = direction_from({std::acos(0.15 + 0.85 * (i + 0.5) / many)}, {2.4 * i});
    if (to_degrees(angle_between(direction, kFitSun)) < 6.0) continue;
    readings.push_back({direction, light(direction), glm::dvec3(0.002), zenith_angle(direction).value / 1.6});
  }
  return readings;
}
RadianceField light_of_dome(const Aerosol& aerosol, double altitude_m = 0.0) {
  return [sky = in_space(dome(altitude_m, aerosol, kFitSun), xyz_to_linear_srgb())](const Direction& view) {
    return dome_light(sky, view);
  };
}
ModelToFit fit_every_model(double altitude_m = 0.0) {
  ModelToFit sky{DaylightModel::automatic, altitude_m};
  sky.every_model = true;
  return sky;
}

TEST(SkyFit, FindsWhatADomeWasMadeOf) {
  for (const Aerosol& aerosol : {Aerosol{0.05, 0.3, AerosolKind::desert}, Aerosol{0.4, 1.1, AerosolKind::smoke}}) {
    const SkyFit fit = fit_sky(readings_over(light_of_dome(aerosol)), kFitSun, fit_every_model(), {});
    ASSERT_TRUE(fit.solved);
    EXPECT_NEAR(fit.found.aerosol.aod_550, aerosol.aod_550, 0.02 * aerosol.aod_550);
    EXPECT_NEAR(fit.found.aerosol.angstrom_exponent, aerosol.angstrom_exponent, 0.1);
    EXPECT_EQ(fit.found.aerosol.kind, aerosol.kind);
    EXPECT_LT(fit.found.papers_share, 1e-6);
    EXPECT_LT(fit.log_residual, 0.01);
    EXPECT_NEAR(fit.turbidity.value, turbidity_of(fit.found.aerosol), 0.05);
    double kinds = 0.0, weights = 0.0;
    for (const double kind : fit.found.kinds) kinds += kind;
    for (const ModelFit& model : fit.models) weights += model.answer.weight;
    EXPECT_NEAR(kinds, 1.0, 1e-9);
    EXPECT_NEAR(weights, 1.0, 1e-9);
    EXPECT_EQ(fit.models.size(), 9u);  // seven kinds, the likeliest blend, Preetham
  }
}

TEST(SkyFit, TheSameLightInAnotherUnitIsTheSameSky) {
  auto readings = readings_over(light_of_dome({0.12, 1.32, AerosolKind::continental}));
  const SkyFit one = fit_sky(readings, kFitSun, fit_every_model(), {});
  for (SkyReading& reading : readings) reading.light *= 1e-4;
  const SkyFit other = fit_sky(readings, kFitSun, fit_every_model(), {});
  EXPECT_NEAR(one.found.aerosol.aod_550, other.found.aerosol.aod_550, 1e-4);
  EXPECT_NEAR(one.models.front().log_luminance_gain - other.models.front().log_luminance_gain, std::log(1e4), 0.01);
}

TEST(SkyFit, WhatIsGivenStays) {
  const auto readings = readings_over(light_of_dome({0.2, 1.32, AerosolKind::continental}));
  ModelToFit sky = fit_every_model();
  sky.known = {.aod_550 = {}, .angstrom_exponent = 0.9, .kind = AerosolKind::urban};
  const SkyFit kind = fit_sky(readings, kFitSun, sky, {});
  EXPECT_EQ(kind.models.size(), 2u);  // and Preetham's
  EXPECT_EQ(kind.found.aerosol.kind, AerosolKind::urban);
  EXPECT_DOUBLE_EQ(kind.found.aerosol.angstrom_exponent, 0.9);
  EXPECT_NEAR(kind.found.covariance.angstrom_exponent, 0.0, 1e-12);
  sky.known = {.aod_550 = 0.3, .angstrom_exponent = {}, .kind = {}};
  const SkyFit amount = fit_sky(readings, kFitSun, sky, {});
  EXPECT_NEAR(amount.found.aerosol.aod_550, 0.3, 1e-9);
  EXPECT_NEAR(amount.found.covariance.aod_550, 0.0, 1e-12);
}

TEST(SkyFit, OneModelAlone) {
  const auto readings = readings_over(light_of_dome({0.2, 1.32, AerosolKind::continental}));
  const SkyFit preetham = fit_sky(readings, kFitSun, {DaylightModel::preetham}, {});
  ASSERT_EQ(preetham.models.size(), 1u);
  EXPECT_EQ(preetham.models.front().answer.name, "preetham");
  EXPECT_DOUBLE_EQ(preetham.found.papers_share, 1.0);
  const SkyFit dome_alone = fit_sky(readings, kFitSun, {DaylightModel::dome}, {});
  EXPECT_EQ(dome_alone.models.size(), kAerosolKinds.size() + 1);  // and a blend
  EXPECT_NEAR(dome_alone.found.aerosol.aod_550, 0.2, 0.01);
}

TEST(SkyFit, LuminanceAloneKnowsTheAmountAndLeavesTheExponentToTheKind) {
  auto readings = readings_over(light_of_dome({0.15, 1.32, AerosolKind::continental}));
  for (SkyReading& reading : readings) reading.light = glm::dvec3((srgb_to_xyz() * reading.light).y);
  const SkyFit fit = fit_sky(readings, kFitSun, fit_every_model(), {.colours = false});
  ASSERT_TRUE(fit.solved);
  EXPECT_NEAR(fit.found.aerosol.aod_550, 0.15, 3.0 * std::sqrt(fit.found.covariance.aod_550));
  EXPECT_LT(std::sqrt(fit.found.covariance.aod_550), 0.15);
  EXPECT_GT(std::sqrt(fit.found.covariance.angstrom_exponent), 0.15);
}

TEST(SkyFit, ASingleCloudMovesLittle) {
  const Aerosol aerosol{0.12, 1.32, AerosolKind::continental};
  const RadianceField clear = light_of_dome(aerosol);
  const Direction cloud = direction_from(from_degrees(40.0), from_degrees(300.0));
  const SkyFit fit =
      fit_sky(readings_over([&](const Direction& view) {
                return to_degrees(angle_between(view, cloud)) < 10.0 ? glm::dvec3(4.0 * clear(view).y) : clear(view);
              }),
              kFitSun, fit_every_model(), {});
  EXPECT_NEAR(fit.found.aerosol.aod_550, aerosol.aod_550, 0.02);
}

TEST(SkyFit, LessIsKnownThroughALensThatIsNotKnown) {
  const Aerosol aerosol{0.12, 1.32, AerosolKind::continental};
  const RadianceField clear = light_of_dome(aerosol);
  auto readings = readings_over(clear);
  for (SkyReading& reading : readings)
    reading.light *= glm::exp(glm::dvec3(0.1, 0.0, -0.1) - 0.2 * reading.off_axis * reading.off_axis);
  const SkyFit known = fit_sky(readings_over(clear), kFitSun, fit_every_model(), {true, 0.02, 0.0});
  const SkyFit unknown = fit_sky(readings, kFitSun, fit_every_model(), {true, 0.1, 0.2});
  EXPECT_NEAR(unknown.found.aerosol.aod_550, aerosol.aod_550, 0.02);
  EXPECT_GT(unknown.found.covariance.aod_550, known.found.covariance.aod_550);
}

TEST(SkyFit, TooFewReadingsAreNoSky) {
  const auto readings = readings_over(light_of_dome({0.12, 1.32, AerosolKind::continental}), 6);
  EXPECT_FALSE(fit_sky(readings, kFitSun, fit_every_model(), {}).solved);
  EXPECT_FALSE(fit_sky({}, kFitSun, fit_every_model(), {}).solved);
}

TEST(ReadingPatches, TakeAWholeSkyTogetherWithoutLosingItsLight) {
  const RadianceField clear = light_of_dome({0.2, 1.32, AerosolKind::continental});
  const auto readings = readings_over(clear, 3000);
  const ReadingPatches places(readings, kFitSun);
  EXPECT_LE(places.size(), 80u);
  EXPECT_GE(places.size(), 40u);
  for (const ReadingPatch& patch : places.gathered(readings, clear))
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(patch.log_light[c], std::log(clear(patch.direction)[c]), 1e-9);
}

TEST(SkyFamily, ItsTableIsTheDome) {
  for (const AerosolKind kind : {AerosolKind::continental, AerosolKind::dust}) {
    const SkyFamily family = SkyFamily::dome(kind, 500.0, kFitSun);
    const std::vector<Direction> views{direction_from(from_degrees(20.0), from_degrees(10.0)),
                                       direction_from(from_degrees(75.0), from_degrees(200.0))};
    const auto table = family.log_light(views);
    for (const double place : {0.4, 3.3, 9.7, 17.6})
      for (const double tilt : {-0.4, 0.0, 0.3}) {
        const FamilyPoint amount{place, tilt};
        const auto light = family.log_light({&table, nullptr}, amount);
        const RadianceField true_light = family.light(amount);
        for (std::size_t i = 0; i < views.size(); ++i)
          for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(light[c][static_cast<Eigen::Index>(i)], std::log(true_light(views[i])[static_cast<int>(c)]),
                        0.003)
                << place << " " << tilt;
      }
  }
}

TEST(CubicTaps, AreExactForParabolas) {
  for (const double place : {0.0, 0.3, 1.0, 4.6, 7.9, 9.0}) {
    const CubicTaps taps = cubic_taps(place, 10);
    double value = 0.0, slope = 0.0;
    for (int k = 0; k < 4; ++k) {
      const double node = taps.first + k, at = 2.0 + 0.5 * node - 0.3 * node * node;
      value += taps.value[static_cast<std::size_t>(k)] * at;
      slope += taps.slope[static_cast<std::size_t>(k)] * at;
    }
    EXPECT_NEAR(value, 2.0 + 0.5 * place - 0.3 * place * place, 1e-12);
    EXPECT_NEAR(slope, 0.5 - 0.6 * place, 1e-12);
  }
}

}  // namespace
}  // namespace kasumi
