#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "estimator/turbidity/sky_samples.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi {
namespace {

struct Scene {
  Camera camera = test::upward_camera(300);
  SkyPicture picture;
  ElementGeometry geometry;
  ElementLight sky;
  Direction sun;
  SampleLimits limits;
};

Scene scene_of(const test::SyntheticSky& description, Camera camera = test::upward_camera(300)) {
  Scene scene;
  scene.camera = std::move(camera);
  const test::RenderedSky rendered = test::render(description, scene.camera);
  const Image<Rgb8> image = rendered.to_8_bit();
  scene.sun = rendered.sun;
  scene.picture = *sky_picture(view_of(image), scene.camera);
  scene.geometry = sky_geometry(scene.camera, scene.picture);
  scene.sky = sky_light(scene.picture, scene.geometry, scene.sun, scene.limits);
  return scene;
}

TEST(ElementGeometry, SolidAnglesOfAHemisphereSumToTwoPi) {
  const Scene scene = scene_of({});
  double sum = 0.0;
  for (const float angle : scene.geometry.solid_angle.elements()) sum += static_cast<double>(angle);
  EXPECT_NEAR(sum, 2.0 * kPi, 0.03 * 2.0 * kPi);  // the rim is a staircase of pixels
}

TEST(SkySamples, AreUniformInSolidAngle) {
  const Scene scene = scene_of({.turbidity = 6.0});
  std::mt19937_64 random(3);
  const auto elements = draw_elements(scene.sky, scene.geometry, 4000, random);
  ASSERT_EQ(elements.size(), 4000u);
  // Away from the sun's half, cos of the zenith angle is uniform between cos 80 deg and 1.
  const double lowest = std::cos(from_degrees(80).value);
  std::array<int, 5> bins{};
  int counted = 0;
  for (const glm::ivec2& e : elements) {
    const glm::vec3& d = scene.geometry.direction.at(e.x, e.y);
    if (glm::dot(Direction(d) * glm::dvec3{1, 1, 0}, scene.sun * glm::dvec3{1, 1, 0}) > 0.0) continue;
    ++bins[std::min<std::size_t>(4, static_cast<std::size_t>((static_cast<double>(d.z) - lowest) / (1 - lowest) * 5))];
    ++counted;
  }
  for (const int bin : bins) EXPECT_NEAR(bin, counted / 5.0, 4.5 * std::sqrt(counted / 5.0));
}

TEST(SkySamples, ReadNearerToTheSunAreAsIfReadAtOnce) {
  Scene scene = scene_of({.turbidity = 3.0});
  SampleLimits nearer = scene.limits;
  nearer.least_sun_distance = from_degrees(3.0);
  const ElementLight at_once = sky_light(scene.picture, scene.geometry, scene.sun, nearer);
  EXPECT_NE(scene.sky.use.elements(), at_once.use.elements());
  read_nearer(scene.sky, scene.picture, scene.geometry, scene.sun, nearer);
  EXPECT_EQ(scene.sky.use.elements(), at_once.use.elements());
  EXPECT_EQ(scene.sky.light.elements(), at_once.light.elements());
  EXPECT_EQ(scene.sky.log_luminance.elements(), at_once.log_luminance.elements());
}

TEST(SkySamples, KeepClearOfSunHorizonSaturationAndMask) {
  Camera camera = test::upward_camera(300);
  camera.mask = Image<std::uint8_t>(300, 300, 255);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 120; ++x) camera.mask.at(x, y) = 0;
  const Scene scene = scene_of({.turbidity = 3.0, .exposure = 2.0}, camera);
  std::mt19937_64 random(3);
  const auto elements = draw_elements(scene.sky, scene.geometry, 3000, random);
  ASSERT_GT(elements.size(), 2000u);
  for (const glm::ivec2& e : elements) {
    const Direction d(scene.geometry.direction.at(e.x, e.y));
    EXPECT_GE(e.x, 120);
    EXPECT_GE(to_degrees(angle_between(d, scene.sun)), 9.99);
    EXPECT_LE(to_degrees(zenith_angle(d)), 80.01);
    const glm::vec3& encoded = scene.picture.encoded.at(e.x, e.y);
    EXPECT_LT(std::max({encoded.r, encoded.g, encoded.b}), 0.985f);
  }
}

TEST(SkySamples, AreDrawnOnceEachAndAllWhenFew) {
  const Scene scene = scene_of({});
  std::mt19937_64 random(3);
  std::set<std::pair<int, int>> seen;
  for (const glm::ivec2& e : draw_elements(scene.sky, scene.geometry, 2000, random))
    EXPECT_TRUE(seen.emplace(e.x, e.y).second);
  const auto clear = static_cast<std::size_t>(std::ranges::count(scene.sky.use.elements(), PixelUse::clear));
  EXPECT_EQ(draw_elements(scene.sky, scene.geometry, 1 << 20, random).size(), clear);
}

// The stated sigma against the actual scatter: thousands of pixels against the unquantised, noiseless truth.
TEST(SkySamples, KnowTheirOwnUncertainty) {
  for (const double noise : {0.0, 0.02}) {
    const Camera camera = test::upward_camera(300);
    Scene scene;
    scene.camera = camera;
    scene.limits.shot_noise = noise;
    const test::SyntheticSky description{.turbidity = 4.0, .noise = noise};
    const test::RenderedSky rendered = test::render(description, camera);
    const Image<Rgb8> image = rendered.to_8_bit();
    scene.picture = *sky_picture(view_of(image), camera);
    scene.geometry = sky_geometry(camera, scene.picture);
    scene.sky = sky_light(scene.picture, scene.geometry, rendered.sun, scene.limits);
    std::mt19937_64 random(3);
    const auto elements = draw_elements(scene.sky, scene.geometry, 5000, random);
    const auto samples =
        samples_at(elements, scene.picture, scene.geometry, scene.sky, camera, rendered.sun, scene.limits);
    std::vector<double> logs;
    double mean = 0.0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const Direction d = *camera.direction_at(glm::dvec2(elements[i]));
      const double truth = std::log(test::preetham_yxy(4.0, zenith_angle(d).value, zenith_angle(rendered.sun).value,
                                                       angle_between(d, rendered.sun).value)
                                        .x);
      logs.push_back(static_cast<double>(samples[i].log_luminance) - truth);
      mean += logs.back() / static_cast<double>(samples.size());
    }
    double normalised = 0.0;
    for (std::size_t i = 0; i < samples.size(); ++i)
      normalised +=
          std::pow((logs[i] - mean) / static_cast<double>(samples[i].sigma), 2) / static_cast<double>(samples.size());
    EXPECT_NEAR(std::sqrt(normalised), 1.0, 0.08) << "noise " << noise;
  }
}

TEST(SkySamples, UndoVignetting) {
  Camera camera = test::upward_camera(300);
  camera.response = Response::linear();
  camera.vignetting = {{149.5, 149.5}, 150.0, {-0.3, -0.1, 0.0}};
  const SkyPicture picture = *sky_picture(Image<glm::vec3>(300, 300, glm::vec3{0.5f}), 0.0, camera);
  const ElementGeometry geometry = sky_geometry(camera, picture);
  const ElementLight sky = sky_light(picture, geometry, direction_from({1.2}, {0.0}), {});
  // At r = 75 px of 150 the falloff is 1 - 0.3 / 4 - 0.1 / 16.
  EXPECT_NEAR(sky.light.at(150, 225).g / sky.light.at(150, 150).g, 1.0 / (1.0 - 0.075 - 0.00625), 2e-3);
}

TEST(SkySamples, SkipWhatIsNotANumber) {
  const Camera camera = test::upward_camera(100);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const SkyPicture picture = *sky_picture(Image<glm::vec3>(100, 100, glm::vec3{0.5f, nan, 0.5f}), 0.0, camera);
  const ElementGeometry geometry = sky_geometry(camera, picture);
  const ElementLight sky = sky_light(picture, geometry, {0.0, 0.0, 1.0}, {});
  EXPECT_EQ(std::ranges::count(sky.use.elements(), PixelUse::clear), 0);
}

}  // namespace
}  // namespace kasumi
