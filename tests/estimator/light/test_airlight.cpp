#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "base/units.hpp"
#include "calib/colour/colorimetry.hpp"
#include "calib/colour/spectral_sensitivity.hpp"
#include "calib/light/radiometry.hpp"
#include "estimator/light/airlight.hpp"
#include "estimator/light/finite_path.hpp"
#include "tests/estimator/light/at_deg.hpp"

namespace kasumi {
namespace {

const glm::dmat3 kLuminanceOnly{glm::dvec3{0.0}, glm::dvec3{1.0}, glm::dvec3{0.0}};  // every channel is Y
const glm::dmat3 kXyzToSrgb = glm::inverse(srgb_to_xyz());

TEST(Zeta, TowardTheSunTheFullRatioFallsWhereThePapersRises) {
  // physics 5: from 80 to 89 deg, T = 2.94, the sun at 58.4 deg in the same azimuth
  const PreethamSky model(Turbidity{2.94}, at_deg(58.4, 180.0));
  const Direction reference = at_deg(80.0, 180.0), view = at_deg(89.0, 180.0);
  EXPECT_NEAR(zeta(ZetaForm::full, model, view, reference, kLuminanceOnly).y, .820, 5e-4);
  EXPECT_NEAR(zeta(ZetaForm::paper, model, view, reference, kLuminanceOnly).y, 1.028, 5e-4);
}

TEST(Zeta, ThePapersFormIsItsEq13) {
  const double t = 3.2;
  const auto factor = [t](double degrees) {
    return 1.0 + (.1787 * t - 1.4630) * std::exp((-.3554 * t + .4275) / std::cos(degrees * kPi / 180.0));
  };
  const PreethamSky model(Turbidity{t}, at_deg(40.0, 90.0));
  EXPECT_NEAR(zeta(ZetaForm::paper, model, at_deg(87.0, 10.0), at_deg(82.0, 10.0), kXyzToSrgb).x,
              factor(87.0) / factor(82.0), 1e-12);
}

TEST(Zeta, IsTheRatioOfTheModelsColours) {
  const PreethamSky model(Turbidity{3.0}, at_deg(50.0, 120.0));
  const Direction view = at_deg(88.0, 60.0), reference = at_deg(78.0, 45.0);
  const glm::dvec3 expected = (kXyzToSrgb * model.xyz(view)) / (kXyzToSrgb * model.xyz(reference));
  const glm::dvec3 found = zeta(ZetaForm::full, model, view, reference, kXyzToSrgb);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 1e-12);
}

TEST(Zeta, IsOneAtItsReferenceAndTheHorizonsBelowTheHorizon) {
  const PreethamSky model(Turbidity{2.5}, at_deg(30.0, 200.0));
  const Direction reference = at_deg(84.0, 10.0);
  for (const auto form : {ZetaForm::full, ZetaForm::paper}) {
    const glm::dvec3 same = zeta(form, model, reference, reference, kXyzToSrgb);
    const glm::dvec3 horizon = zeta(form, model, at_deg(90.0, 10.0), reference, kXyzToSrgb);
    const glm::dvec3 below = zeta(form, model, at_deg(97.0, 10.0), reference, kXyzToSrgb);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(same[c], 1.0, 1e-12);
      EXPECT_NEAR(below[c], horizon[c], 1e-9);
    }
  }
}

TEST(Zeta, IsPositiveAndFiniteForAnyTurbiditySunAndDirection) {
  std::mt19937_64 random(20260621);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  for (int i = 0; i < 20000; ++i) {
    const PreethamSky model(Turbidity{uniform(0.0, 30.0)},
                            raised_to_horizon(at_deg(uniform(0.0, 120.0), uniform(0.0, 360.0))));
    Direction view = at_deg(uniform(0.0, 180.0), uniform(0.0, 360.0));
    if (i % 10 == 0) view = model.sun();       // into the sun
    if (i % 10 == 1) view = {0.0, 0.0, -1.0};  // nadir
    if (i % 10 == 2) view = at_deg(90.0, uniform(0.0, 360.0));
    const Direction reference = at_deg(uniform(60.0, 90.0), uniform(0.0, 360.0));
    for (const auto form : {ZetaForm::full, ZetaForm::paper}) {
      const glm::dvec3 ratio = zeta(form, model, view, reference, kXyzToSrgb);
      for (int c = 0; c < 3; ++c) {
        ASSERT_TRUE(std::isfinite(ratio[c]) && ratio[c] > 0.0)
            << ratio[c] << " at T " << model.turbidity().value << ", sun " << to_degrees(zenith_angle(model.sun()));
      }
    }
  }
}

// The model's sky as measured by a perfect camera with linear sRGB channels and an unknown gain.
HorizonLight measured(const PreethamSky& model, double gain, double first_azimuth, double last_azimuth, double zenith) {
  HorizonLight horizon;
  horizon.source = HorizonLight::Source::scene_camera;
  constexpr int kColumns = 9;
  for (int i = 0; i < kColumns; ++i) {
    const double azimuth = std::lerp(first_azimuth, last_azimuth, i / (kColumns - 1.0));
    const Direction view = at_deg(zenith, azimuth);
    horizon.columns.push_back({azimuth_angle(view), from_degrees(zenith), gain * (kXyzToSrgb * model.xyz(view)), 1.0});
  }
  return horizon;
}

TEST(Airlight, CarriesAHorizonMeasuredHigherUpToWhatTheModelShowsThere) {
  const SunDirection sun = at_deg(55.0, 150.0);
  const PreethamSky model(Turbidity{2.94}, sun);
  const double gain = 0.037;
  const Airlight airlight(measured(model, gain, 330.0, 390.0, 80.0), Turbidity{2.94}, sun, srgb_to_xyz());
  for (const double azimuth : {331.0, 345.0, 0.0, 13.0, 29.0}) {
    for (const double zenith : {75.0, 85.0, 89.0, 90.0}) {
      const Direction view = at_deg(zenith, azimuth);
      const glm::dvec3 expected = gain * (kXyzToSrgb * model.xyz(view));
      const glm::dvec3 found = airlight.from(view);
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / expected[c], 1.0, 2e-3) << azimuth << " " << zenith;
    }
  }
}

TEST(Airlight, HoldsTheMeasuredEdgeBeyondTheViewAndFollowsTheModelFromThere) {
  const SunDirection sun = at_deg(40.0, 90.0);
  const PreethamSky model(Turbidity{4.0}, sun);
  const Airlight airlight(measured(model, 1.0, 350.0, 370.0, 85.0), Turbidity{4.0}, sun, srgb_to_xyz());
  const Direction outside = at_deg(86.0, 40.0);
  const glm::dvec3 expected = kXyzToSrgb * model.xyz(outside), found = airlight.from(outside);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / expected[c], 1.0, 1e-6);
}

TEST(Airlight, IsNeverNegativeWhateverWasMeasured) {
  HorizonLight horizon;
  horizon.columns.push_back({from_degrees(10.0), from_degrees(85.0), {-0.1, 0.0, 1e-12}, 0.0});
  const Airlight airlight(horizon, Turbidity{1.0}, at_deg(95.0, 0.0), srgb_to_xyz());
  const glm::dvec3 light = airlight.from(at_deg(89.0, 12.0));
  for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(light[c]) && light[c] >= 0.0);
}

TEST(HorizonColumns, AreInterpolatedAcrossNorth) {
  HorizonLight horizon;
  horizon.columns = {{from_degrees(350.0), from_degrees(80.0), glm::dvec3{1.0}, 1.0},
                     {from_degrees(0.0), from_degrees(82.0), glm::dvec3{2.0}, 1.0},
                     {from_degrees(10.0), from_degrees(84.0), glm::dvec3{3.0}, 1.0}};
  EXPECT_NEAR(column_at(horizon, from_degrees(355.0)).light.x, 1.5, 1e-9);
  EXPECT_NEAR(column_at(horizon, from_degrees(355.0)).azimuth.value, from_degrees(355.0).value, 1e-9);
  EXPECT_NEAR(column_at(horizon, from_degrees(5.0)).light.x, 2.5, 1e-9);
  EXPECT_NEAR(to_degrees(column_at(horizon, from_degrees(5.0)).zenith), 83.0, 1e-9);
  EXPECT_EQ(column_at(horizon, from_degrees(300.0)).light.x, 1.0);
  EXPECT_EQ(column_at(horizon, from_degrees(60.0)).light.x, 3.0);
}

TEST(HorizonBlend, MovesFromThePreviousToTheCurrentByItsWeight) {
  HorizonLight before, after;
  before.columns = {{from_degrees(10.0), from_degrees(80.0), glm::dvec3{1.0}, 1.0}};
  after.columns = {{from_degrees(10.0), from_degrees(84.0), glm::dvec3{3.0}, 1.0}};
  EXPECT_NEAR(blend(before, after, 0.25).columns[0].light.x, 1.5, 1e-12);
  EXPECT_NEAR(to_degrees(blend(before, after, 0.25).columns[0].zenith), 81.0, 1e-9);
  EXPECT_EQ(blend(before, after, 1.0).columns[0].light.x, 3.0);
  EXPECT_EQ(blend(before, after, 0.0).columns[0].light.x, 1.0);
  EXPECT_EQ(blend({}, after, 0.0).columns[0].light.x, 3.0);
  EXPECT_EQ(blend(before, {}, 1.0).columns[0].light.x, 1.0);
}

TEST(FinitePath, LeavesPreethamsWorldAsItIs) {
  const Direction sun = direction_from(from_degrees(50.0), from_degrees(200.0));
  const AirState air{Turbidity{3.0}};
  const FinitePath paths(SiteSky(DaylightModel::automatic, air, sun, 300.0), air, sun, 300.0, glm::dmat3(1.0));
  EXPECT_EQ(paths.factor({0.0, 1.0, 0.0}, 80.0, glm::dvec3(0.7)), glm::dvec3(1.0));
}

}  // namespace
}  // namespace kasumi
