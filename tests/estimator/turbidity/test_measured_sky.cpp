// The light of clouds, as seen by the sky camera, on the object.
#include <cmath>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "calib/colour/colorimetry.hpp"
#include "calib/lens/lens.hpp"
#include "estimator/light/object_light.hpp"
#include "estimator/turbidity/measured_sky.hpp"

namespace kasumi {
namespace {

Direction at_deg(double zenith, double azimuth) {
  return direction_from(from_degrees(zenith), from_degrees(azimuth));
}
Camera srgb_camera() {
  Camera camera;
  camera.colour_space = Camera::ColourSpace::srgb;
  return camera;
}

// Every cell open, with `radiance` (XYZ) at its centre.
template <class Radiance>
MeasuredSky whole_sky(const Radiance& radiance, double clear) {
  MeasuredSky sky;
  for (int ring = 0; ring < MeasuredSky::kRings; ++ring)
    for (int sector = 0; sector < MeasuredSky::kSectors; ++sector)
      sky.cells[static_cast<std::size_t>(ring * MeasuredSky::kSectors + sector)] = {
          radiance(MeasuredSky::centre_of(ring, sector)), 1.0, clear, false};
  return sky;
}

void expect_same(const LightOnObject& a, const LightOnObject& b, double tolerance) {
  for (const Direction& normal : {at_deg(0, 0), at_deg(90, 0), at_deg(90, 90), at_deg(90, 200), at_deg(45, 300)}) {
    const glm::dvec3 ratio = irradiance(a.around, normal) / irradiance(b.around, normal);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(ratio[c], 1.0, tolerance);
  }
}

TEST(MeasuredSky, AClearOneChangesNothingWhateverItsUnitAndColour) {
  const SunDirection sun = at_deg(50.0, 180.0);
  const PreethamSky model(Turbidity{3.0}, sun);
  const auto sky = whole_sky(
      [&](const Direction& d) {
        return glm::dvec3{3e-4, 2e-4, 5e-4} * model.relative_xyz(d);
      },
      1.0);
  DaylightConditions options;
  const Daylight without(srgb_camera(), Turbidity{3.0}, sun, options);
  options.measured = &sky;
  const Daylight with(srgb_camera(), Turbidity{3.0}, sun, options);
  expect_same(with.on_object(), without.on_object(), 1e-12);
  EXPECT_EQ(with.on_object().sun_irradiance, without.on_object().sun_irradiance);
}

TEST(MeasuredSky, AnOvercastOneLightsByItsOwnDistributionWhateverTheExposure) {
  // Brighter in the east than the CIE's sky, in its own unit and with a wrong white balance: the level stays the CIE's,
  // the distribution is the picture's.
  const SunDirection sun = at_deg(40.0, 90.0);
  const auto uneven = [](const Direction& d) { return (1.0 + 2.0 * d.z) / 3.0 * (d.x > 0.0 ? 1.3 : 1.0); };
  DaylightConditions options;
  options.sky = SkyCondition::overcast;
  LightOnObject lights[2];
  int i = 0;
  for (const glm::dvec3& unit : {glm::dvec3{1.0}, glm::dvec3{2e-5, 1e-5, 3e-5}}) {
    const auto sky = whole_sky([&](const Direction& d) { return uneven(d) * unit; }, 0.0);
    options.measured = &sky;
    lights[i++] = Daylight(srgb_camera(), Turbidity{5.0}, sun, options).on_object();
  }
  expect_same(lights[0], lights[1], 1e-9);
  EXPECT_EQ(lights[0].sun_irradiance, glm::dvec3{0.0});
  const double east = irradiance(lights[0].around, at_deg(90, 90)).y;
  const double west = irradiance(lights[0].around, at_deg(90, 270)).y;
  EXPECT_GT(east, 1.1 * west);
}

TEST(MeasuredSky, CloudsLightTheObjectAsTheirNumericalIntegralSays) {
  // White clouds, five times the zenith's luminance, over the southern half.
  const SunDirection sun = at_deg(50.0, 0.0);
  const PreethamSky model(Turbidity{2.5}, sun);
  const glm::dvec3 white{0.95, 1.0, 1.09};
  auto sky = whole_sky([&](const Direction& d) { return d.y < 0.0 ? 5.0 * white : model.relative_xyz(d); }, 1.0);
  for (auto& cell : sky.cells)
    if (glm::length(cell.xyz - 5.0 * white) < 1e-9) cell.clear = 0.0;
  sky.sun_share = 0.3;
  DaylightConditions options;
  options.ground_albedo = 0.0;
  const Daylight clear(srgb_camera(), Turbidity{2.5}, sun, options);
  options.measured = &sky;
  const Daylight clouded(srgb_camera(), Turbidity{2.5}, sun, options);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(clouded.on_object().sun_irradiance[c] / clear.on_object().sun_irradiance[c], 0.3, 1e-12);

  const glm::dvec3 zenith = clear.airlight(at_deg(0, 0));
  const glm::dvec3 to_srgb_white = glm::dvec3{1.0};  // D65 of luminance 1 is white of 1
  const double unit = zenith.y / (glm::inverse(srgb_to_xyz()) * model.relative_xyz(at_deg(0, 0))).y;
  for (const Direction& normal : {at_deg(0, 0), at_deg(90, 180), at_deg(90, 90), at_deg(45, 0)}) {
    glm::dvec3 truth{0.0};
    constexpr int kSteps = 180;
    for (int i = 0; i < kSteps; ++i)
      for (int j = 0; j < 2 * kSteps; ++j) {
        const double polar = (i + 0.5) * 0.5 * kPi / kSteps;
        const Direction d = direction_from({polar}, {(j + 0.5) * kPi / kSteps});
        const double cosine = std::max(0.0, glm::dot(d, normal));
        const double solid_angle = std::sin(polar) * 0.5 * kPi * kPi / kSteps / kSteps;
        truth += cosine * solid_angle * (d.y < 0.0 ? 5.0 * unit * to_srgb_white : clear.airlight(d));
      }
    const glm::dvec3 found = irradiance(clouded.on_object().around, normal);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c] / truth[c], 1.0, 0.04) << c;
  }
}

TEST(MeasuredSky, ACloudShadesTheObjectFromWhereItsSunRayMeetsTheClouds) {
  const SunDirection sun = at_deg(45.0, 180.0);
  // 3 km north, clouds 2 km up: the ray meets the clouds 1 km north of the camera.
  const Direction through = towards_shading_cloud({0.0, 3000.0, 0.0}, sun, 2000.0);
  EXPECT_NEAR(through.x, 0.0, 1e-12);
  EXPECT_NEAR(through.y / through.z, 0.5, 1e-12);
  EXPECT_NEAR(angle_between(towards_shading_cloud({0.0, 0.0, 0.0}, sun, 2000.0), sun).value, 0.0, 1e-9);
  EXPECT_EQ(towards_shading_cloud({0.0, 3000.0, 2500.0}, sun, 2000.0), sun);  // above the clouds
}

// A fisheye of 200 x 200 px that looks straight up, and its picture.
class SkyPhotograph : public testing::Test {
 protected:
  SkyPhotograph() {
    camera.name = "sky";
    camera.width = camera.height = kSide;
    camera.lens = equidistant_lens({99.5, 99.5}, 99.0 / (0.5 * kPi), from_degrees(90.0));
    camera.to_world = camera_to_world(Radians{kPi}, from_degrees(90.0), Radians{0.0});
    camera.response = Response::linear();
    picture.encoded = Image<glm::vec3>(kSide, kSide, glm::vec3(0.4f));
    picture.quantum = 1.0 / 255.0;
    geometry = sky_geometry(camera, picture);
    use = Image<PixelUse>(kSide, kSide, PixelUse::clear);
  }
  void paint(const Direction& centre, double radius_deg, float value, PixelUse as) {
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x)
        if (angle_between(glm::dvec3(geometry.direction.at(x, y)), centre) < from_degrees(radius_deg)) {
          picture.encoded.at(x, y) = glm::vec3(value);
          use.at(x, y) = as;
        }
  }
  MeasuredSky measured(SkyCondition condition, const Direction& through) const {
    return measure_sky(picture, geometry, camera, use, condition, sun, through);
  }

  static constexpr int kSide = 200;
  const SunDirection sun = at_deg(40.0, 120.0);
  Camera camera;
  SkyPicture picture;
  ElementGeometry geometry;
  Image<PixelUse> use;
};

TEST_F(SkyPhotograph, OfAnEvenSkyIsEvenInEveryCell) {
  const auto sky = measured(SkyCondition::clear, sun);
  const glm::dvec3 expected = camera.light_to_xyz() * glm::dvec3{0.4};
  for (int ring = 0; ring < MeasuredSky::kRings - 1; ++ring)
    for (int sector = 0; sector < MeasuredSky::kSectors; ++sector) {
      const MeasuredCell& cell = sky.at(MeasuredSky::centre_of(ring, sector));
      if (cell.seen == 0.0) continue;  // near the zenith a cell is smaller than the sampling grid
      EXPECT_NEAR(cell.xyz.y / expected.y, 1.0, 1e-5);
    }
}

TEST_F(SkyPhotograph, TheSunShinesWhereItsDiscIsSaturated) {
  EXPECT_EQ(measured(SkyCondition::partly_cloudy, sun).sun_share, 0.0);
  paint(sun, 10.0, 0.8f, PixelUse::near_sun);
  paint(sun, 2.0, 1.0f, PixelUse::near_sun);
  EXPECT_EQ(measured(SkyCondition::partly_cloudy, sun).sun_share, 1.0);
  EXPECT_EQ(measured(SkyCondition::overcast, sun).sun_share, 0.0);
}

TEST_F(SkyPhotograph, InAClearSkyTheDiscsOwnFewPixelsTellThatALowSunShines) {
  EXPECT_EQ(measured(SkyCondition::clear, sun).sun_share, 0.0);
  paint(sun, 0.8, 1.0f, PixelUse::near_sun);
  for (int y = 0; y < kSide; ++y)  // reddened by the long path through the air
    for (int x = 0; x < kSide; ++x)
      if (picture.encoded.at(x, y).r == 1.0f) picture.encoded.at(x, y) = {1.0f, 0.9f, 0.5f};
  EXPECT_EQ(measured(SkyCondition::clear, sun).sun_share, 1.0);
  // Near clouds it may be a cloud's bright edge.
  paint(at_deg(55.0, 120.0), 8.0, 0.7f, PixelUse::cloud);
  EXPECT_EQ(measured(SkyCondition::clear, sun).sun_share, 0.0);
}

TEST_F(SkyPhotograph, ACloudBeforeTheObjectsSunTakesItThoughOursShines) {
  paint(sun, 2.0, 1.0f, PixelUse::near_sun);
  const Direction through = at_deg(30.0, 10.0);
  EXPECT_EQ(measured(SkyCondition::partly_cloudy, through).sun_share, 1.0);
  paint(through, 4.0, 0.7f, PixelUse::cloud);
  EXPECT_EQ(measured(SkyCondition::partly_cloudy, through).sun_share, 0.0);
  // The glow of a low sun is not a cloud: there our own sun decides.
  paint(through, 4.0, 1.0f, PixelUse::saturated);
  EXPECT_EQ(measured(SkyCondition::partly_cloudy, through).sun_share, 1.0);
}

TEST_F(SkyPhotograph, HiddenAndClippedCellsAreMarked) {
  paint(at_deg(60.0, 300.0), 15.0, 1.0f, PixelUse::saturated);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      if (geometry.direction.at(x, y).y > 0.0f) geometry.open.at(x, y) = 0;
  const auto sky = measured(SkyCondition::partly_cloudy, sun);
  EXPECT_EQ(sky.at(at_deg(50.0, 5.0)).seen, 0.0);
  EXPECT_GT(sky.at(at_deg(52.0, 185.0)).seen, 0.9);
  EXPECT_FALSE(sky.at(at_deg(52.0, 185.0)).clipped);
}

}  // namespace
}  // namespace kasumi
