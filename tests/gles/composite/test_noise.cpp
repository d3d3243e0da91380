// The object's noise against the camera's: its variance at every light level, and no noise anywhere else.
#include <cmath>

#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

class Noise : public GlesTest {
 protected:
  // White, without air, over all or part of the picture: its light is the measured airlight's.
  ReferenceScene wall(double width_m = 4000.0) const {
    ReferenceScene scene;
    scene.view = view_north(256, 192, 6000);
    scene.model = box_model(width_m, 4000, 0.01, 1);
    scene.model.materials[0].base_colour = {1.0f, 1.0f, 1.0f, 1.0f};
    scene.model_to_world = model_to_world({0, 3500, -2000, {}, 1.0});
    scene.appearance = furnace(1.0);
    scene.response.kind = ResponseCurve::Kind::linear;
    scene.measured = measured_airlight(scene.view);
    return scene;
  }
  Image<Rgb8> noisy(Renderer& renderer, const ReferenceScene& scene, const SensorNoise& noise,
                    const Image<Rgb8>& camera) {
    Offscreen target = make_target(scene.view.width, scene.view.height);
    EXPECT_TRUE(renderer.upload(view_of(camera)));
    EXPECT_TRUE(renderer.draw(scene.measured, target.target(), noise));
    return target.read().value();
  }
};

struct Statistics {
  double mean = 0.0;
  double variance = 0.0;
};
Statistics statistics_of(const Image<Rgb8>& picture, int channel) {
  double sum = 0.0, squares = 0.0;
  for (const Rgb8& pixel : picture.elements())
    sum += pixel[channel], squares += double(pixel[channel]) * pixel[channel];
  const double count = double(picture.elements().size()), mean = sum / count;
  return {mean, squares / count - mean * mean};
}

TEST_F(Noise, HasTheModelsVarianceAtEveryLightLevelAndKeepsTheMean) {
  ReferenceScene scene = wall();
  Renderer renderer = loaded(scene);
  const Image<Rgb8> camera(256, 192);
  const SensorNoise noise{glm::dvec3{1.0, 1.5, 2.0} / 900.0, glm::dvec3{0.004, 0.01, 0.02}, 7};
  for (const double light : {0.1, 0.2, 0.4, 0.6, 0.8}) {
    scene.measured.light.fill(glm::dvec3{light});
    const auto picture = noisy(renderer, scene, noise, camera);
    for (int c = 0; c < 3; ++c) {
      const auto [mean, variance] = statistics_of(picture, c);
      // Dither and rounding add 1/6 of a step's square on average: a step's rounding with thresholds spread over it.
      const double model = 255.0 * 255.0 * (noise.shot[c] * light + noise.read[c] * noise.read[c]) + 1.0 / 6.0;
      // 49152 pixels: the variance is known to .6 %, the mean to deviation / 220; three and a half times that.
      EXPECT_NEAR(variance, model, 0.023 * model) << "light " << light << ", channel " << c;
      EXPECT_NEAR(mean, 255.0 * light, 0.02 + 3.5 * std::sqrt(model) / 220.0) << "light " << light << ", channel " << c;
    }
  }
}

TEST_F(Noise, IsUnbiasedInLinearLightBehindACurvedResponse) {
  ReferenceScene scene = wall();
  scene.response.kind = ResponseCurve::Kind::srgb;
  Renderer renderer = loaded(scene);
  for (const double light : {0.08, 0.3, 0.6}) {
    scene.measured.light.fill(glm::dvec3{light});
    const auto picture =
        noisy(renderer, scene, {glm::dvec3{1.0 / 2000.0}, glm::dvec3{0.001}, 3}, Image<Rgb8>(256, 192));
    double mean = 0.0;
    for (const Rgb8& pixel : picture.elements())
      mean += reference_light(scene.response, 1, pixel.g / 255.0) / double(picture.elements().size());
    EXPECT_NEAR(mean, light, 0.002 * light + 3.5 * std::sqrt(light / 2000.0) / 220.0);
  }
}

TEST_F(Noise, RepeatsForTheSameFrameAndDiffersForTheNext) {
  static_assert(kNoisePatterns == 4, "of the numbers below, 41 and 45 have one pattern");
  ReferenceScene scene = wall();
  scene.measured.light.fill(glm::dvec3{0.4});
  Renderer renderer = loaded(scene), other = loaded(scene);
  const Image<Rgb8> camera(256, 192);
  SensorNoise noise{glm::dvec3{1.0 / 900.0}, glm::dvec3{0.01}, 41};
  const auto first = noisy(renderer, scene, noise, camera);
  EXPECT_EQ(first.elements(), noisy(other, scene, noise, camera).elements());
  noise.pattern = 45;
  EXPECT_EQ(first.elements(), noisy(other, scene, noise, camera).elements());
  for (const std::uint32_t number : {42u, 43u, 0u}) {
    noise.pattern = number;
    const auto next = noisy(renderer, scene, noise, camera);
    // Two frames' noise is uncorrelated: the correlation of 49152 pairs is below 4 / sqrt(49152).
    const auto a = statistics_of(first, 1), b = statistics_of(next, 1);
    double together = 0.0;
    for (std::size_t i = 0; i < next.elements().size(); ++i)
      together += (first.elements()[i].g - a.mean) * (next.elements()[i].g - b.mean) / double(next.elements().size());
    EXPECT_LE(std::abs(together) / std::sqrt(a.variance * b.variance), 0.018) << "frame " << number;
  }
}

TEST_F(Noise, ShowsNoPattern) {
  // Neighbours in every direction, and channels among each other, are uncorrelated.
  ReferenceScene scene = wall();
  scene.measured.light.fill(glm::dvec3{0.4});
  Renderer renderer = loaded(scene);
  const auto picture = noisy(renderer, scene, {glm::dvec3{1.0 / 500.0}, glm::dvec3{0.0}, 5}, Image<Rgb8>(256, 192));
  const auto correlation = [&](int dx, int dy, int a, int b) {
    const auto one = statistics_of(picture, a), other = statistics_of(picture, b);
    double sum = 0.0;
    int count = 0;
    for (int y = std::max(0, -dy); y < std::min(192, 192 - dy); ++y)
      for (int x = std::max(0, -dx); x < std::min(256, 256 - dx); ++x, ++count)
        sum += (picture.at(x, y)[a] - one.mean) * (picture.at(x + dx, y + dy)[b] - other.mean);
    return sum / count / std::sqrt(one.variance * other.variance);
  };
  for (const auto& [dx, dy] :
       {std::pair{1, 0}, {0, 1}, {1, 1}, {-1, 1}, {2, 0}, {0, 2}, {8, 0}, {0, 8}, {64, 0}, {0, 64}})
    EXPECT_LE(std::abs(correlation(dx, dy, 1, 1)), 0.025) << dx << ", " << dy;
  EXPECT_LE(std::abs(correlation(0, 0, 0, 1)), 0.025);
  EXPECT_LE(std::abs(correlation(0, 0, 1, 2)), 0.025);
}

TEST_F(Noise, LeavesPixelsWithoutTheObjectUnchanged) {
  for (const auto& scene : {wall(40.0), box_scene()}) {
    Renderer renderer = loaded(scene);
    const Image<Rgb8> camera = landscape(scene.view.width, scene.view.height);
    const auto layer = renderer.read_layer().value();
    const PixelBox box = renderer.object_box();
    const auto picture = noisy(renderer, scene, {glm::dvec3{0.01}, glm::dvec3{0.05}, 1}, camera);
    int uncovered = 0, changed = 0;
    for (int y = 0; y < camera.height(); ++y)
      for (int x = 0; x < camera.width(); ++x) {
        const bool in_box = x >= box.left && x < box.right && y >= box.top && y < box.bottom;
        if (in_box && layer.at(x - box.left, y - box.top).a > 0.0f) {
          changed += picture.at(x, y) != camera.at(x, y) ? 1 : 0;
          continue;
        }
        ++uncovered;
        ASSERT_EQ(picture.at(x, y), camera.at(x, y)) << x << ", " << y;
      }
    EXPECT_GT(uncovered, 1000);
    EXPECT_GT(changed, 1000);
  }
}

TEST_F(Noise, AddsOnlyTheMissingNoiseBehindASoftMask) {
  // A mask of 2/5 everywhere: the camera's own noise comes through at 3/5, so the object's must add 1 - (3/5)^2 of the
  // variance. The picture behind is uniform and noiseless.
  ReferenceScene scene = wall();
  scene.mask = Image<std::uint8_t>(256, 192, 102);
  scene.measured.light.fill(glm::dvec3{0.5});
  Renderer renderer = loaded(scene);
  const Image<Rgb8> camera(256, 192, Rgb8{128, 128, 128});
  const auto [mean, variance] =
      statistics_of(noisy(renderer, scene, {glm::dvec3{1.0 / 500.0}, glm::dvec3{0.0}, 9}, camera), 1);
  const double light = 0.6 * 128.0 / 255.0 + 0.4 * 0.5;
  const double model = 255.0 * 255.0 * (1.0 - 0.36) * light / 500.0 + 1.0 / 6.0;
  EXPECT_NEAR(mean, 255.0 * light, 0.1);
  EXPECT_NEAR(variance, model, 0.03 * model);
}

TEST_F(Noise, ImpossibleValuesAreRefused) {
  const ReferenceScene scene = wall();
  Renderer renderer = loaded(scene);
  Offscreen target = make_target(256, 192);
  const Image<Rgb8> camera(256, 192);
  ASSERT_OK(renderer.upload(view_of(camera)));
  EXPECT_THAT(renderer.draw(scene.measured, target.target(), {glm::dvec3{-1.0}, {}, 0}).error().message,
              HasSubstr("noise"));
  EXPECT_FALSE(renderer.draw(scene.measured, target.target(), {glm::dvec3{std::nan("")}, {}, 0}));
}

}  // namespace
}  // namespace kasumi
