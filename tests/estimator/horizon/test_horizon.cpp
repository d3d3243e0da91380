#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include <glm/common.hpp>

#include "calib/colour/colorimetry.hpp"
#include "estimator/horizon/horizon.hpp"
#include "tests/estimator/horizon/drawn_scene.hpp"

namespace kasumi {
namespace {

// Intersection over union of two masks.
double agreement(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  double both = 0.0, either = 0.0;
  for (std::size_t i = 0; i < a.elements().size(); ++i) {
    both += a.elements()[i] != 0 && b.elements()[i] != 0 ? 1.0 : 0.0;
    either += a.elements()[i] != 0 || b.elements()[i] != 0 ? 1.0 : 0.0;
  }
  return both / either;
}

TEST(SkySegmentation, FindsASkyOverTexturedGround) {
  const DrawnScene scene = draw(drawn_camera(), {});
  const SkySegmentation found = segment_sky(scene.picture);
  EXPECT_TRUE(found.visible) << found.reason;
  EXPECT_GT(agreement(found.sky, scene.sky), 0.97);
}

TEST(SkySegmentation, WithstandsNoise) {
  DrawnOptions options;
  options.noise = 8.0;
  const DrawnScene scene = draw(drawn_camera(), options);
  const SkySegmentation found = segment_sky(scene.picture);
  EXPECT_TRUE(found.visible) << found.reason;
  EXPECT_GT(agreement(found.sky, scene.sky), 0.95);
}

TEST(SkySegmentation, KeepsATowersSilhouetteOut) {
  DrawnOptions options;
  options.front = [](int x, int y) {
    return x > 280 && x < 360 && y > 60 ? 3.0 * drawn_ground(x, y) : glm::dvec3{-1.0};
  };
  const DrawnScene scene = draw(drawn_camera(), options);
  const SkySegmentation found = segment_sky(scene.picture);
  EXPECT_GT(agreement(found.sky, scene.sky), 0.95);
  EXPECT_EQ(found.sky.at(320, 120), 0);
}

TEST(SkySegmentation, FindsASkyThatBranchesKeepFromTheTop) {
  DrawnOptions options;
  options.front = [](int x, int y) { return y < 50 ? 0.5 * drawn_ground(x, y) : glm::dvec3{-1.0}; };
  const DrawnScene scene = draw(drawn_camera(), options);
  const SkySegmentation found = segment_sky(scene.picture);
  EXPECT_TRUE(found.visible) << found.reason;
  EXPECT_GT(agreement(found.sky, scene.sky), 0.9);
}

TEST(SkySegmentation, TakesCloudsForSky) {
  DrawnOptions options;
  options.sky = [](const Direction& direction) {
    const double cloud = std::sin(25.0 * direction.x + 3.0) * std::sin(60.0 * direction.z);
    return glm::mix(drawn_sky(direction), glm::dvec3{0.75, 0.76, 0.78}, std::clamp(2.0 * cloud - 0.6, 0.0, 1.0));
  };
  const DrawnScene scene = draw(drawn_camera(), options);
  const SkySegmentation found = segment_sky(scene.picture);
  EXPECT_TRUE(found.visible) << found.reason;
  EXPECT_GT(agreement(found.sky, scene.sky), 0.95);
}

TEST(SkySegmentation, FindsNoneInAPictureOfGround) {
  DrawnOptions options;
  options.front = drawn_ground;
  const SkySegmentation found = segment_sky(draw(drawn_camera(), options).picture);
  EXPECT_FALSE(found.visible);
  EXPECT_EQ(found.reason, "no sky: nothing bright and textureless in the upper part");
}

TEST(SkySegmentation, ReportsThatANightIsDark) {
  DrawnOptions options;
  options.noise = 2.0;
  options.front = [](int, int) { return glm::dvec3{0.002}; };
  const SkySegmentation found = segment_sky(draw(drawn_camera(), options).picture);
  EXPECT_FALSE(found.visible);
  EXPECT_EQ(found.reason, "no sky: the picture is dark");
}

TEST(SkySegmentation, RefusesATinyPictureAndAMaskOfAnotherSize) {
  EXPECT_FALSE(segment_sky(Image<Rgb8>(8, 8)).visible);
  EXPECT_FALSE(segment_sky(Image<Rgb8>()).visible);
  EXPECT_FALSE(segment_sky(Image<Rgb8>(640, 360), Image<std::uint8_t>(64, 36)).visible);
}

TEST(Horizon, MeasuresTheSkysLightAboveTheGround) {
  const Camera camera = drawn_camera();
  const DrawnScene scene = draw(camera, {});
  const HorizonLight horizon = measure_horizon(camera, view_of(scene.picture));
  ASSERT_TRUE(horizon.usable()) << horizon.reason;
  EXPECT_EQ(horizon.source, HorizonLight::Source::scene_camera);
  EXPECT_EQ(horizon.columns.size(), 16U);
  EXPECT_LT(worst_light_error(horizon), 0.01);
  for (const HorizonColumn& column : horizon.columns) {
    EXPECT_GT(to_degrees(column.zenith), 88.0);
    EXPECT_LE(to_degrees(column.zenith), 90.0);
    EXPECT_GT(column.quality, 0.9);
  }
  // Heading 20 deg, 49.1 deg wide: strips of 3 deg from -3.1 to 43.1 deg.
  EXPECT_NEAR(std::remainder(to_degrees(horizon.columns.front().azimuth), 360.0), -3.1, 0.3);
  EXPECT_NEAR(to_degrees(horizon.columns.back().azimuth), 43.1, 0.3);
}

TEST(Horizon, AveragesNoiseAway) {
  const Camera camera = drawn_camera();
  DrawnOptions options;
  options.noise = 6.0;
  const DrawnScene scene = draw(camera, options);
  const HorizonLight horizon = measure_horizon(camera, view_of(scene.picture));
  ASSERT_TRUE(horizon.usable()) << horizon.reason;
  EXPECT_LT(worst_light_error(horizon), 0.02);
}

TEST(Horizon, LooksAboveHillsThatFadeIntoTheSky) {
  const Camera camera = drawn_camera();
  DrawnOptions options;
  options.noise = 1.0;
  options.front = [&](int x, int y) {
    const double ridge = 200.0 + 8.0 * std::sin(0.02 * x) + 4.0 * std::sin(0.07 * x);
    const Direction direction = *camera.direction_at({x, y});
    if (y < ridge || direction.z <= 0.0) return glm::dvec3{-1.0};
    return 0.9 * drawn_sky(direction);
  };
  const DrawnScene scene = draw(camera, options);
  const HorizonLight horizon = measure_horizon(camera, view_of(scene.picture));
  ASSERT_TRUE(horizon.usable()) << horizon.reason;
  EXPECT_LT(worst_light_error(horizon), 0.02);  // the hills would be 10 % off
}

TEST(Horizon, IsMeasuredHigherUpBehindATowerAndOutvotesAChimney) {
  const Camera camera = drawn_camera();
  DrawnOptions options;
  options.front = [](int x, int y) {
    if (x > 320 && x < 400 && y > 100) return 3.0 * drawn_ground(x, y);
    if (x > 80 && x < 112 && y > 195 && y < 226) return glm::dvec3{0.70, 0.70, 0.70};  // a pale smooth tank
    return glm::dvec3{-1.0};
  };
  const DrawnScene scene = draw(camera, options);
  const HorizonLight horizon = measure_horizon(camera, view_of(scene.picture));
  ASSERT_TRUE(horizon.usable()) << horizon.reason;
  EXPECT_LT(to_degrees(column_at(horizon, from_degrees(23.2)).zenith), 86.0);  // over the tower, x = 360
  EXPECT_LT(worst_light_error(horizon), 0.04);
}

TEST(Horizon, UsesAClippedSkysValueAndReportsIt) {
  const Camera camera = drawn_camera();
  DrawnOptions options;
  options.sky = [](const Direction&) { return glm::dvec3{2.0}; };
  const DrawnScene scene = draw(camera, options);
  const HorizonLight horizon = measure_horizon(camera, view_of(scene.picture));
  ASSERT_TRUE(horizon.usable()) << horizon.reason;
  EXPECT_EQ(horizon.reason, "the horizon sky is clipped: its light is a lower bound");
  for (const HorizonColumn& column : horizon.columns) {
    EXPECT_NEAR(column.light.y, 1.0, 1e-3);
    EXPECT_LT(column.quality, 0.2);
  }
}

TEST(Horizon, ACameraThatLooksDownSeesNone) {
  // A pale textureless square fills the picture: only the camera's pose shows that it cannot be sky.
  const Camera camera = drawn_camera(-30.0);
  DrawnOptions options;
  options.front = [](int, int) { return glm::dvec3{0.6}; };
  const HorizonLight horizon = measure_horizon(camera, view_of(draw(camera, options).picture));
  EXPECT_FALSE(horizon.usable());
  EXPECT_EQ(horizon.source, HorizonLight::Source::none);
  EXPECT_NE(horizon.reason.find("no sky"), std::string::npos) << horizon.reason;
}

TEST(Horizon, RefusesAPictureOfAnotherSize) {
  const Image<Rgb8> picture(320, 240);
  const HorizonLight horizon = measure_horizon(drawn_camera(), view_of(picture));
  EXPECT_FALSE(horizon.usable());
  EXPECT_EQ(horizon.reason, "picture is 320x240, the scene camera 640x360");
}

TEST(Horizon, SamePictureGivesTheSameBits) {
  const Camera camera = drawn_camera();
  const DrawnScene scene = draw(camera, {});
  const auto first = measure_horizon(camera, view_of(scene.picture)),
             second = measure_horizon(camera, view_of(scene.picture));
  ASSERT_EQ(first.columns.size(), second.columns.size());
  for (std::size_t i = 0; i < first.columns.size(); ++i) EXPECT_EQ(first.columns[i].light, second.columns[i].light);
}

// A fisheye with its own exposure under the synthetic sky.
struct PanoramaView {
  Camera camera;
  Image<Rgb8> picture;
};
PanoramaView look_up(double exposure) {
  PanoramaView view;
  view.camera.name = "sky";
  view.camera.width = view.camera.height = 400;
  view.camera.lens = equidistant_lens({199.5, 199.5}, 195.0 / (kPi / 2.0), from_degrees(92.0));
  view.camera.to_world = camera_to_world({0.0}, from_degrees(90.0), {0.0});
  view.camera.vignetting.radius_px = 200.0;
  view.picture = Image<Rgb8>(400, 400);
  for (int y = 0; y < 400; ++y) {
    for (int x = 0; x < 400; ++x) {
      const auto direction = view.camera.direction_at({x, y});
      if (!direction || direction->z < 0.0) continue;
      const glm::dvec3 light = glm::clamp(exposure * drawn_sky(*direction), 0.0, 1.0);
      view.picture.at(x, y) = Rgb8(glm::round(255.0 * view.camera.response.to_encoded(light)));
    }
  }
  return view;
}

TEST(SkyRing, SetsItsLevelByTheBrightestDistantThings) {
  const PanoramaView sky = look_up(0.5);
  const Camera camera = drawn_camera(0.0);
  DrawnOptions options;  // a hazy wall of hills, no sky
  options.front = [](int x, int y) { return y < 200 ? glm::dvec3{0.25} : drawn_ground(x, y); };
  const DrawnScene scene = draw(camera, options);
  const HorizonLight horizon =
      horizon_from_sky_camera(sky.camera, view_of(sky.picture), camera, view_of(scene.picture));
  ASSERT_TRUE(horizon.usable()) << horizon.reason;
  EXPECT_NE(horizon.reason.find("assumed"), std::string::npos);
  EXPECT_EQ(horizon.source, HorizonLight::Source::sky_camera);
  double luminance = 0.0;
  const auto level = [](const HorizonColumn& column) {
    return column.light.x / drawn_sky(direction_from(column.zenith, column.azimuth)).x;
  };
  for (const HorizonColumn& column : horizon.columns) {
    EXPECT_NEAR(to_degrees(column.zenith), 80.0, 1e-9);
    EXPECT_NEAR(level(column) / level(horizon.columns.front()), 1.0, 0.03) << "distribution over azimuth";
    luminance += (srgb_to_xyz() * column.light).y / static_cast<double>(horizon.columns.size());
    EXPECT_LE(column.quality, 0.3);
    const glm::dvec3 truth = drawn_sky(direction_from(column.zenith, column.azimuth));  // colour
    EXPECT_NEAR(column.light.x / column.light.z, truth.x / truth.z, 0.03 * truth.x / truth.z);
  }
  EXPECT_NEAR(luminance, 0.25, 0.005);
}

TEST(SkyRing, ReportsThatTheRingIsMasked) {
  PanoramaView sky = look_up(0.5);
  sky.camera.mask = Image<std::uint8_t>(400, 400, 0);
  const Camera camera = drawn_camera();
  const DrawnScene scene = draw(camera, {});
  const HorizonLight horizon =
      horizon_from_sky_camera(sky.camera, view_of(sky.picture), camera, view_of(scene.picture));
  EXPECT_FALSE(horizon.usable());
  EXPECT_NE(horizon.reason.find("masked"), std::string::npos) << horizon.reason;
}

TEST(SkyRing, IsTheModelsWhereNoCameraShowsSky) {
  const Camera camera = drawn_camera(0.0);
  DrawnOptions options;
  options.front = [](int x, int y) { return y < 200 ? glm::dvec3{0.25} : drawn_ground(x, y); };
  const DrawnScene scene = draw(camera, options);
  const auto xyz = [](const Direction& view) { return 7e3 * (srgb_to_xyz() * drawn_sky(view)); };
  const HorizonLight horizon = horizon_from_model(xyz, camera, view_of(scene.picture));
  ASSERT_TRUE(horizon.usable()) << horizon.reason;
  EXPECT_EQ(horizon.source, HorizonLight::Source::model);
  double luminance = 0.0;
  for (const HorizonColumn& column : horizon.columns) {
    luminance += (srgb_to_xyz() * column.light).y / static_cast<double>(horizon.columns.size());
    const glm::dvec3 truth = drawn_sky(direction_from(column.zenith, column.azimuth));
    EXPECT_NEAR(column.light.x / column.light.z, truth.x / truth.z, 1e-6 * truth.x / truth.z);
  }
  EXPECT_NEAR(luminance, 0.25, 0.005) << "as bright as the brightest distant things";
}

TEST(SkyRing, OfTheModelNeedsSomethingToSetItsLevelBy) {
  const Camera camera = drawn_camera(0.0);
  const Image<Rgb8> black(camera.width, camera.height);
  const auto horizon = horizon_from_model([](const Direction&) { return glm::dvec3{1.0}; }, camera, view_of(black));
  EXPECT_FALSE(horizon.usable());
  EXPECT_FALSE(horizon.reason.empty());
}

}  // namespace
}  // namespace kasumi
