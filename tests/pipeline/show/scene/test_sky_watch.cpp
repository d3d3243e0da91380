// The state of the air as both cameras' pictures move it, and the air that the picture is then drawn under.
#include <algorithm>
#include <cmath>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include "calib/colour/camera_saturation.hpp"
#include "calib/lens/lens.hpp"
#include "capture/codec/encode.hpp"
#include "estimator/air/scattering.hpp"
#include "pipeline/show/scene/air_figures.hpp"
#include "pipeline/show/scene/scene_air.hpp"
#include "pipeline/show/scene/sky_watch.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr double kAltitude_m = 300.0;
constexpr Instant kStart{1h};

Installation site(DaylightModel model = DaylightModel::automatic) {
  Installation installation;
  installation.site.altitude_m = kAltitude_m;
  installation.surroundings.sky_model = model;
  installation.sky.width = installation.sky.height = 32;
  installation.sky.lens = equidistant_lens({15.5, 15.5}, 10.0, from_degrees(90.0));
  return installation;
}

TurbidityEstimate estimate_of(const FoundAerosol& found) {
  TurbidityEstimate estimate;
  estimate.usable = true;
  estimate.sky = SkyCondition::clear;
  estimate.turbidity = Turbidity{turbidity_of(found.aerosol)};
  estimate.sigma = 0.1;
  estimate.found = found;
  return estimate;
}

FoundAerosol smoke(double aod_550) {
  FoundAerosol found{{aod_550, 1.8, AerosolKind::smoke}, {4e-4, 0.0, 0.01}, {}, 0.0};
  found.kinds[static_cast<std::size_t>(AerosolKind::smoke)] = 1.0;
  return found;
}

TurbidityEstimate closed_sky() {
  TurbidityEstimate estimate;
  estimate.sky = SkyCondition::overcast;
  estimate.reason = "overcast";
  return estimate;
}

// Extinction of a column's aerosol, and of molecules, at the site.
TrackerReading path_through(const Aerosol& aerosol, Instant when, double relative_sigma = 0.05) {
  PathReading path;
  for (std::size_t c = 0; c < 3; ++c) {
    const double wavelength_nm = std::array{610.0, 540.0, 460.0}[c];
    const double per_m =
        optical_depth(aerosol, wavelength_nm) / kAerosolHeight_m * std::exp(-kAltitude_m / kAerosolHeight_m) +
        rayleigh_per_m(ScatteringModel::aerosol, wavelength_nm, kAltitude_m);
    path.channels[c] = {PathReading::Channel::Kind::value, wavelength_nm, per_m, 0.3 * relative_sigma * per_m};
  }
  path.shared_sigma = relative_sigma;
  return {when, path, std::nullopt};
}

// A watch whose sky camera sees what the test says.
class SkyWatchTest : public testing::Test {
 protected:
  SkyWatch watch_over(const Installation& installation) {
    ObservationPlan options;
    options.estimator = [seen = seen](const SkyPicture&, const SunDirection& sun) {
      auto estimate = *seen;
      estimate.sun = sun;
      return estimate;
    };
    return SkyWatch(installation, options);
  }
  SkyReport look(SkyWatch& watch, Instant when) {
    auto frame = encode_frame(Image<Rgb8>(32, 32, Rgb8(90)), four_cc("RGB3")).value();
    frame.metadata.utc = Utc{std::chrono::sys_days{std::chrono::year{2026} / 6 / 21} + 3h};
    return watch.observe(frame, when, SunSource::ephemeris).value();
  }
  AirState drawn_under(const Installation& installation, const SkyReport& report) {
    return SceneAir(installation, {}).conditions(report).air;
  }
  std::shared_ptr<TurbidityEstimate> seen = std::make_shared<TurbidityEstimate>(closed_sky());
};

TEST_F(SkyWatchTest, WhileNobodySeesTheAirItIsSupposedAndSaidToBe) {
  auto watch = watch_over(site());
  const auto report = look(watch, kStart);
  ASSERT_TRUE(report.air);
  EXPECT_TRUE(report.air->supposed);
  EXPECT_THAT(report.air->text(), HasSubstr("the air is supposed"));
  EXPECT_FALSE(report.seen_air()) << "no T was found";
  EXPECT_FALSE(seen_quality(report, kAltitude_m));
  EXPECT_FALSE(watch.to_remember(kStart, report.utc));
  EXPECT_EQ(observers_text(*report.air), "supposed");
}

TEST_F(SkyWatchTest, TheAerosolFoundDrivesThePicture) {
  auto watch = watch_over(site());
  *seen = estimate_of(smoke(0.5));
  const auto report = look(watch, kStart);
  ASSERT_TRUE(report.seen_air());
  const auto air = drawn_under(site(), report);
  EXPECT_TRUE(air.aerosol_known());
  EXPECT_NEAR(air.aerosol().aod_550, 0.5, 0.02);
  EXPECT_EQ(air.aerosol().kind, AerosolKind::smoke);
  EXPECT_NEAR(air.aerosol().angstrom_exponent, 1.8, 0.1);
  EXPECT_EQ(report.seen_air()->air.turbidity(), air.turbidity());
  EXPECT_TRUE(report.seen_air()->trustworthy);
  EXPECT_NEAR(seen_quality(report, kAltitude_m)->aod_550, air.aerosol().aod_550, 1e-9);
}

TEST_F(SkyWatchTest, UnderThePapersSkyTAloneDrivesThePicture) {
  auto watch = watch_over(site());
  FoundAerosol found{aerosol_of(4.0), {1e-4, 0.0, 0.1}, {}, 0.97};
  *seen = estimate_of(found);
  const auto report = look(watch, kStart);
  const auto air = drawn_under(site(), report);
  EXPECT_FALSE(air.aerosol_known());
  EXPECT_NEAR(air.turbidity().value, 4.0, 0.1);
  EXPECT_GT(aod_sigma(*report.air), 0.0) << "what is not sure of T";
}

TEST_F(SkyWatchTest, OfAnAerosolKnownInPartThePapersSkyIsNotBelieved) {
  auto installation = site();
  installation.surroundings.air.kind = AerosolKind::maritime;
  auto watch = watch_over(installation);
  *seen = estimate_of({aerosol_of(4.0), {1e-4, 0.0, 0.1}, {}, 0.97});
  const auto air = drawn_under(installation, look(watch, kStart));
  EXPECT_TRUE(air.aerosol_known());
  EXPECT_EQ(air.aerosol().kind, AerosolKind::maritime);
}

TEST_F(SkyWatchTest, LandmarksCarryThePictureUnderAClosedSky) {
  auto watch = watch_over(site());
  const Aerosol haze{0.6, 1.3, AerosolKind::continental};
  watch.observe(path_through(haze, kStart));
  const auto report = look(watch, kStart);
  ASSERT_TRUE(report.seen_air());
  EXPECT_FALSE(report.air->supposed);
  EXPECT_TRUE(report.seen_air()->trustworthy);
  EXPECT_EQ(report.air->observers.size(), 1U) << "the sky camera said nothing";
  const auto air = drawn_under(site(), report);
  EXPECT_NEAR(air.aerosol().aod_550 * air.near_ground(), 0.6, 0.05);
  EXPECT_THAT(observers_text(*report.air), HasSubstr("landmarks"));
}

TEST_F(SkyWatchTest, TheLowSkyOfTheSceneCameraIsAnObserver) {
  auto watch = watch_over(site());
  watch.observe({kStart, std::nullopt, ColumnReading{AirObserver::horizon, smoke(0.5)}});
  const auto report = watch.at(kStart, Utc{}, SunSource::none);
  EXPECT_FALSE(report.air->supposed);
  EXPECT_THAT(observers_text(*report.air), HasSubstr("horizon"));
}

TEST_F(SkyWatchTest, AReadingBetweenTwoSkyFramesIsInTheNextPicture) {
  auto watch = watch_over(site());
  const auto before = look(watch, kStart);
  watch.observe(path_through({0.6, 1.3, AerosolKind::continental}, kStart + 1s));
  const auto after = watch.with_air(before, kStart + 1s);
  EXPECT_FALSE(before.seen_air());
  ASSERT_TRUE(after.seen_air());
  EXPECT_EQ(after.utc, before.utc);
  EXPECT_EQ(after.picture, before.picture);
  EXPECT_EQ(after.estimate.reason, before.estimate.reason);
}

TEST_F(SkyWatchTest, WhatTheSkySaysAloneIsKeptForComparison) {
  auto watch = watch_over(site());
  *seen = estimate_of(smoke(0.2));
  const auto by_sky = [](const SkyReport& report) {
    return std::ranges::find(report.air->observers, AirObserver::sky, &ObserverPart::by)->aod_550;
  };
  const double alone = by_sky(look(watch, kStart));
  EXPECT_NEAR(alone, 0.2, 0.01);
  for (int i = 0; i < 5; ++i) watch.observe(path_through({0.8, 1.8, AerosolKind::smoke}, kStart + i * 60s));
  const auto report = watch.at(kStart + 5min, Utc{}, SunSource::none);
  EXPECT_EQ(by_sky(report), alone) << "the landmarks are not in it";
  EXPECT_GT(std::abs(largest_disagreement_sigmas(*report.air)), 0.0);
}

TEST_F(SkyWatchTest, AGivenAirIsDrawnWhateverIsSeen) {
  auto installation = site();
  installation.surroundings.air = {0.3, 1.0, AerosolKind::urban};
  auto watch = watch_over(installation);
  *seen = estimate_of(smoke(0.9));
  const auto report = look(watch, kStart);
  EXPECT_EQ(drawn_under(installation, report), AirState(Aerosol{0.3, 1.0, AerosolKind::urban}));
  EXPECT_EQ(report.air->air.aerosol().aod_550, 0.3);
  EXPECT_TRUE(report.seen_air()->trustworthy);
}

TEST_F(SkyWatchTest, TheWholeStateGoesOnAfterARestart) {
  auto first = watch_over(site());
  *seen = estimate_of(smoke(0.5));
  for (int i = 0; i < 30; ++i) (void)look(first, kStart + i * 10s);
  const auto kept = first.to_remember(kStart + 10min, Utc{2h});
  ASSERT_TRUE(kept);
  auto second = watch_over(site());
  second.remember(*kept, kStart + 5min);
  const auto before = first.at(kStart + 10min, Utc{}, SunSource::none).air.value(),
             after = second.at(kStart + 10min, Utc{}, SunSource::none).air.value();
  EXPECT_FALSE(after.supposed);
  EXPECT_NEAR(after.believed.aerosol().aod_550, before.believed.aerosol().aod_550, 0.02);
  EXPECT_EQ(after.air.aerosol().kind, AerosolKind::smoke);
}

TEST_F(SkyWatchTest, ATOfAnOldFileIsRememberedAsAir) {
  auto watch = watch_over(site());
  watch.remember(Turbidity{5.0}, 0.2, kStart);
  const auto report = watch.at(kStart + 1min, Utc{}, SunSource::none);
  ASSERT_TRUE(report.seen_air());
  EXPECT_NEAR(report.seen_air()->air.turbidity().value, 5.0, 0.5);
  EXPECT_THAT(observers_text(*report.air), HasSubstr("remembered"));
}

TEST_F(SkyWatchTest, NonsenseIsNotRemembered) {
  auto watch = watch_over(site());
  watch.remember(Turbidity{std::nan("")}, 0.2, kStart);
  EXPECT_TRUE(watch.at(kStart, Utc{}, SunSource::none).air->supposed);
}

// Learnt from landmarks, the scene camera's saturation reaches what the picture is drawn under; what the configuration
// says goes before it, and a camera that was measured has none.
TEST(SceneCamerasSaturation, IsLearntUnlessItIsKnown) {
  auto installation = site();
  installation.scene.width = installation.scene.height = 32;
  installation.scene.lens = pinhole_lens({{30.0, 30.0}, {15.5, 15.5}, {}});
  SkyWatch watch(installation);
  EXPECT_FALSE(watch.with_air({}, kStart).scene_saturation);
  TrackerReading reading;
  reading.when = kStart;
  reading.saturation = 1.6;
  EXPECT_FALSE(reading.empty());
  watch.observe(reading);
  const auto report = watch.with_air({}, kStart);
  ASSERT_TRUE(report.scene_saturation);

  const auto drawn_by = [&](const SkyReport& now) { return SceneAir(installation, {}).conditions(now).saturation; };
  EXPECT_EQ(drawn_by(SkyReport{}), 1.0);
  EXPECT_EQ(drawn_by(report), 1.6);
  const SceneAir air(installation, {});
  EXPECT_EQ(air.measured(air.conditions(SkyReport{}), {0, 0, 32, 32}).saturation, 1.0);
  installation.scene.colour_space = Camera::ColourSpace::sensor;
  EXPECT_EQ(drawn_by(report), 1.0);
  installation.scene_quality.saturation = 1.2;
  EXPECT_EQ(drawn_by(report), 1.2);
}

// The twelfth hazy picture of a kiosk's first month must not change the building's colours before a visitor's eyes.
TEST(SceneCamerasSaturation, ComesInOverMinutesWhereItIsLearntWhileOneLooks) {
  SkyWatch watch(site());
  TrackerReading reading;
  reading.when = kStart;
  watch.observe(reading);  // nothing is known of it yet
  EXPECT_FALSE(watch.with_air({}, kStart).scene_saturation);
  reading.when = kStart + std::chrono::minutes(30);
  reading.saturation = 1.6;
  watch.observe(reading);
  const auto after_s = [&](int seconds) {
    return watch.with_air({}, reading.when + std::chrono::seconds(seconds)).scene_saturation.value_or(0.0);
  };
  EXPECT_EQ(after_s(0), 1.0);
  EXPECT_LT(after_s(1), 1.005);
  EXPECT_NEAR(after_s(3600), 1.6, 1e-3);
}

// The horizon is taken back by as much as what is drawn in it is saturated: endless air looks as the camera shows it.
TEST(SceneCamerasSaturation, LeavesTheHorizonAsItIsSeen) {
  auto installation = site();
  installation.scene.width = installation.scene.height = 32;
  installation.scene.lens = pinhole_lens({{30000.0, 30000.0}, {15.5, 15.5}, {}});
  installation.scene.to_world = glm::dmat3({1, 0, 0}, {0, 0, -1}, {0, 1, 0})  // level, to the north
      ;
  installation.scene.white_balance = {0.9, 1.0, 1.3};
  installation.scene_quality.saturation = 1.7;
  SceneAir air(installation, {});
  const auto seen_with = [&](SceneAir& by) {
    HorizonAnswer answer{by.observer(), {}, {}};
    answer.seen.source = HorizonLight::Source::scene_camera;
    answer.seen.columns = {{Radians{0.0}, from_degrees(90.0), {0.3, 0.4, 0.45}, 1.0}};
    by.adopt(answer);
    return by.measured(by.conditions(SkyReport{}), {0, 0, 32, 32});
  };
  const auto grid = seen_with(air);
  installation.scene_quality.saturation = 1.0;
  SceneAir plain(installation, {});
  const auto as_seen = seen_with(plain);
  ASSERT_EQ(grid.saturation, 1.7);
  for (std::size_t i = 0; i < grid.light.size(); ++i) {
    const auto shown = with_saturation(grid.light[i], grid.saturation);
    EXPECT_NEAR(glm::distance(shown, as_seen.light[i]) / as_seen.light[i].g, 0.0, 0.01) << i;
    EXPECT_LT(grid.light[i].b, as_seen.light[i].b);
  }
}

// A card that can no longer be read tells nothing of today's light.
TEST(CardsInTheScene, AreForgottenWhereTheyAreNotReadForLong) {
  auto installation = site();
  installation.cards = {{"wall", 0, 0, 4, 4, glm::dvec3{0.4}, {0, 0, 1}}};
  SceneAir air(installation, {});
  HorizonAnswer answer{air.observer(), {}, {}};
  answer.cards = {{glm::dvec3{1.5}, glm::dvec3{0.0}}};
  air.adopt(answer);
  const double read = air.cards()->factors.around.g;
  ASSERT_GT(read, 1.2);
  answer.cards.clear();
  const auto after = [&](std::chrono::minutes unread) {
    answer.metadata.captured_at += unread;
    air.adopt(answer);
    return air.cards()->factors.around.g;
  };
  EXPECT_GT(after(std::chrono::minutes(2)), 1.0 + 0.9 * (read - 1.0));
  EXPECT_NEAR(after(std::chrono::hours(3)), 1.0, 0.01);
}

// What cards say reaches the light on the object, and a layer drawn without it is another.
TEST(CardsInTheScene, CorrectTheLightOnTheObject) {
  auto installation = site();
  installation.scene.width = installation.scene.height = 32;
  installation.scene.lens = pinhole_lens({{30.0, 30.0}, {15.5, 15.5}, {}});
  installation.scene.to_world = glm::dmat3({1, 0, 0}, {0, 0, -1}, {0, 1, 0});
  SceneAir air(installation, {});
  SkyReport report;
  report.sun = {SunSource::ephemeris, SunDirection{0.0, -0.6, 0.8}, std::nullopt, false, {}};
  const auto before = air.conditions(report);
  HorizonAnswer answer{air.observer(), {}, {}};
  answer.cards = {{glm::dvec3{1.3}, glm::dvec3{0.0}}, {glm::dvec3{0.8}, glm::dvec3{0.9}}};
  air.adopt(answer);
  const auto after = air.conditions(report);
  EXPECT_FALSE(look_alike(after, before));
  EXPECT_TRUE(look_alike(after, after));
  EXPECT_LT(after.by_cards.sun.g, 0.95);
  EXPECT_GT(after.by_cards.around.g, 1.05);
  const PixelBox box{0, 0, 32, 32};
  const auto plain = air.appearance(before, box).light, corrected = air.appearance(after, box).light;
  EXPECT_NEAR(corrected.sun_irradiance.g / plain.sun_irradiance.g, after.by_cards.sun.g, 1e-6);
  EXPECT_NEAR(irradiance(corrected.around, {0, 0, 1}).g / irradiance(plain.around, {0, 0, 1}).g,
              after.by_cards.around.g, 1e-4);
}

}  // namespace
}  // namespace kasumi
