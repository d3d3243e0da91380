#include <algorithm>

#include <gtest/gtest.h>

#include "estimator/turbidity/cloud_mask.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"

namespace kasumi {
namespace {

struct Score {
  double cloud_found = 1.0;  // share of the cloudy solid angle that was masked
  double clear_kept = 1.0;   // share of the clear solid angle kept
  double clear_fraction = 0.0;
};

Score mask(const test::SyntheticSky& description) {
  const Camera camera = test::upward_camera(300);
  const test::RenderedSky rendered = test::render(description, camera);
  const Image<Rgb8> image = rendered.to_8_bit();
  const SkyPicture picture = *sky_picture(view_of(image), camera);
  const ElementGeometry geometry = sky_geometry(camera, picture);
  ElementLight sky = sky_light(picture, geometry, rendered.sun, {});
  const ElementLight before = sky;
  const CloudMaskResult result = mask_clouds(sky, geometry, rendered.sun);
  double cloudy = 0.0, found = 0.0, clear = 0.0, kept = 0.0;
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 300; ++x) {
      if (before.use.at(x, y) != PixelUse::clear) continue;
      const auto angle = static_cast<double>(geometry.solid_angle.at(x, y));
      const bool out = sky.use.at(x, y) == PixelUse::cloud;
      if (rendered.cloud.at(x, y) != 0) {
        cloudy += angle;
        if (out) found += angle;
      } else {
        clear += angle;
        if (!out) kept += angle;
      }
    }
  return {cloudy > 0.0 ? found / cloudy : 1.0, kept / clear, result.clear_fraction};
}

TEST(CloudMask, KeepsAClearSkyWholeFromDeepBlueToWhitish) {
  for (const double sun : {25.0, 58.4, 75.0})
    for (const double t : {2.0, 4.0, 6.0, 9.0, 14.0}) {
      const Score score = mask({.turbidity = t, .sun_zenith_deg = sun});
      EXPECT_GT(score.clear_kept, 0.97) << "T " << t << ", sun " << sun;
      EXPECT_GT(score.clear_fraction, 0.98) << "T " << t << ", sun " << sun;
    }
}

TEST(CloudMask, IsTheSameByLooksThatAreKnown) {
  const Camera camera = test::upward_camera(300);
  for (const double cover : {0.0, 0.3, 0.6}) {
    const test::RenderedSky rendered =
        test::render({.turbidity = 4.0, .cloud_cover = cover, .cloud_seed = 11u, .noise = 0.01}, camera);
    const Image<Rgb8> image = rendered.to_8_bit();
    const SkyPicture picture = *sky_picture(view_of(image), camera);
    const ElementGeometry geometry = sky_geometry(camera, picture);
    ElementLight sky = sky_light(picture, geometry, rendered.sun, {});
    const ElementLooks looks = looks_of(picture, camera, sky);
    const Image<PixelUse> by_looks = CloudMasks(sky, looks, geometry, rendered.sun, {}).by({});
    mask_clouds(sky, geometry, rendered.sun);
    int other = 0;
    for (std::size_t i = 0; i < sky.use.elements().size(); ++i)
      other += sky.use.elements()[i] != by_looks.elements()[i];
    EXPECT_LT(other, 10) << "cover " << cover;  // of 90000: rounding at a limit
    const auto clouds = std::ranges::count(by_looks.elements(), PixelUse::cloud);
    EXPECT_EQ(clouds > 9000, cover > 0.0) << "cover " << cover;
  }
}

TEST(CloudMask, KeepsAClearSkyOfANoisyCamera) {
  EXPECT_GT(mask({.turbidity = 4.0, .noise = 0.02}).clear_kept, 0.95);
}

TEST(CloudMask, FindsConnectedCloudsAndLeavesEnoughSkyBesideThem) {
  for (const double cover : {0.3, 0.5})
    for (const double t : {2.0, 4.0, 6.0, 9.0})
      for (const std::uint64_t seed : {11u, 12u}) {
        const Score score = mask({.turbidity = t, .cloud_cover = cover, .cloud_seed = seed});
        EXPECT_GT(score.cloud_found, t > 8.0 ? 0.75 : 0.9) << "T " << t << ", cover " << cover << ", seed " << seed;
        EXPECT_GT(score.clear_kept, 0.5) << "T " << t << ", cover " << cover << ", seed " << seed;
      }
}

// Where only a fifth of the sky is left, what agrees best must still win over what is merely most: a wide cell of clouds.
TEST(CloudMask, FindsMostSkiesOfWhichAFifthIsClear) {
  int found = 0;
  for (const double t : {2.0, 3.0, 4.0, 6.0})
    for (const std::uint64_t seed : {11u, 12u, 13u})
      found += mask({.turbidity = t, .cloud_cover = 0.8, .cloud_seed = seed}).cloud_found > 0.9;
  EXPECT_GE(found, 8) << "of 12: whoever gives the rest less weight takes the clouds for the sky";
}

// A camera whose white balance is off by a third in red and blue shifts every colour by the same factor.
TEST(CloudMask, DoesNotDependOnTheWhiteBalance) {
  Camera camera = test::upward_camera(300);
  const test::RenderedSky rendered = test::render({.turbidity = 3.0, .exposure = 0.7}, camera);
  camera.white_balance = {1.3, 1.0, 0.75};
  const Image<Rgb8> image = rendered.to_8_bit();
  const SkyPicture picture = *sky_picture(view_of(image), camera);
  const ElementGeometry geometry = sky_geometry(camera, picture);
  ElementLight sky = sky_light(picture, geometry, rendered.sun, {});
  EXPECT_GT(mask_clouds(sky, geometry, rendered.sun).clear_fraction, 0.95);
}

TEST(CloudMask, MasksOutliersOfAFit) {
  const Camera camera = test::upward_camera(300);
  const test::RenderedSky rendered = test::render({.turbidity = 3.0}, camera);
  const Image<Rgb8> image = rendered.to_8_bit();
  const SkyPicture picture = *sky_picture(view_of(image), camera);
  const ElementGeometry geometry = sky_geometry(camera, picture);
  ElementLight sky = sky_light(picture, geometry, rendered.sun, {});
  // The gain that makes the model fit, from one element; then a patch ten per cent brighter.
  const glm::dvec3 d(geometry.direction.at(150, 100));
  const double s = zenith_angle(rendered.sun).value, gamma = angle_between(d, rendered.sun).value;
  const double a = .1787 * 3 - 1.4630, b = -.3554 * 3 + .4275, c = -.0227 * 3 + 5.3251, e = -.0670 * 3 + .3703;
  const double f =
      (1 + a * std::exp(b / d.z)) * (1 + c * std::exp((.1206 * 3 - 2.5771) * gamma) + e * std::pow(std::cos(gamma), 2));
  ASSERT_GT(s, 0.0);
  const double gain = static_cast<double>(sky.log_luminance.at(150, 100)) - std::log(f);
  for (int y = 180; y < 200; ++y)
    for (int x = 140; x < 160; ++x) sky.log_luminance.at(x, y) += 0.1f;
  const double left = mask_outliers(sky, geometry, rendered.sun, Turbidity{3.0}, gain, 0.03);
  EXPECT_GT(left, 0.98);
  for (int y = 180; y < 200; ++y)
    for (int x = 140; x < 160; ++x) EXPECT_NE(sky.use.at(x, y), PixelUse::clear);
  EXPECT_EQ(sky.use.at(150, 150), PixelUse::clear);
}

}  // namespace
}  // namespace kasumi
