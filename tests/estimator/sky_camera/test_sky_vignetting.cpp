// Vignetting from the clear sky, on generated skies through a lens with known vignetting.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/sky_camera/sky_vignetting.hpp"
#include "fixtures/generator/generator.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

constexpr int kSize = 260;

struct Day {
  std::vector<SunMoment> moments;
  Camera camera;
};

// The sun's path over a day; T differs from picture to picture. `sky_error`: how much brighter than the model the real
// sky is 80 deg from the zenith, growing with the square of the angle.
Day day(std::uint64_t seed, double turbidity, int pictures, double cloud_cover = 0.0, double sky_error = 0.0) {
  Day made;
  for (int i = 0; i < pictures; ++i) {
    fixtures::FisheyeRecipe recipe;
    recipe.size = kSize;
    recipe.seed = 100 * seed + static_cast<std::uint64_t>(i);
    recipe.noise = recipe.vignetting = recipe.obstructions = true;
    recipe.cloud_cover = cloud_cover;
    recipe.turbidity = turbidity + 0.2 * std::sin(3.0 * i + static_cast<double>(seed));
    const double hour = pictures > 1 ? static_cast<double>(i) / (pictures - 1) - 0.5 : 0.2;
    recipe.sun_zenith = from_degrees(32.0 + 95.0 * hour * hour + 20.0 * std::abs(hour));
    recipe.sun_azimuth = from_degrees(180.0 + 160.0 * hour + 10.0 * static_cast<double>(seed));
    const auto taken = fixtures::sky_picture(recipe);
    made.camera = taken.camera;
    Image<glm::vec3> encoded(kSize, kSize);
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        glm::dvec3 value = glm::dvec3(taken.pixels.at(x, y)) / 255.0;
        const auto direction = taken.camera.direction_at({x, y});
        if (sky_error != 0.0 && direction && direction->z > 0.0) {
          const double off = zenith_angle(*direction).value / from_degrees(80.0).value;
          value =
              taken.camera.response.to_encoded(taken.camera.response.to_light(value) * (1.0 + sky_error * off * off));
          value = glm::round(255.0 * glm::min(value, glm::dvec3(1.0))) / 255.0;
        }
        encoded.at(x, y) = glm::vec3(value);
      }
    made.moments.push_back({fmt::format("{}", i), sky_picture(encoded, 1.0 / 255.0, taken.camera).value(), taken.sun});
  }
  return made;
}

// The largest error of the illumination within `reach` of the 90 deg that the lens images; relative.
double worst(const FoundVignetting& found, const Camera& truth, double reach = 80.0 / 90.0) {
  double largest = 0.0;
  for (double r = 0.0; r <= reach; r += 0.02) {
    const glm::dvec2 pixel = truth.vignetting.centre + glm::dvec2{0.5 * kSize * r, 0.0};
    const double error = found.vignetting.at(pixel) / truth.vignetting.at(pixel) - 1.0;
    if (std::abs(error) > std::abs(largest)) largest = error;
  }
  return largest;
}

TEST(FoundVignetting, SkiesThatFollowTheModelGiveTheLensToAPercent) {
  for (const auto& [seed, turbidity, clouds] :
       {std::tuple{1, 2.7, 0.0}, std::tuple{2, 3.6, 0.0}, std::tuple{3, 5.1, 0.0}, std::tuple{4, 4.0, 0.3}}) {
    const auto made = day(static_cast<std::uint64_t>(seed), turbidity, 6, clouds);
    const auto found = must(vignetting_from_sky(made.camera, made.moments));
    const double error = worst(*found, made.camera);
    std::printf("T about %.1f, clouds %.1f: %+.2f %% at worst within 80 deg, %+.2f %% within 90; said: %.2f %%\n",
                turbidity, clouds, 100.0 * error, 100.0 * worst(*found, made.camera, 1.0), 100.0 * found->rim_sigma);
    EXPECT_LE(std::abs(error), 0.01);
    EXPECT_LE(std::abs(error), 3.0 * found->rim_sigma);
    EXPECT_LE(found->rim_sigma, 0.04);
    EXPECT_GE(found->pictures, 5);
  }
}

TEST(FoundVignetting, ASkyBrighterAtTheRimThanTheModelIsMistakenForTheLensWithinTheStatedError) {
  const auto made = day(5, 3.4, 6, 0.0, 0.03);
  const auto found = must(vignetting_from_sky(made.camera, made.moments));
  EXPECT_NEAR(found->by_3_percent_at_rim, 0.03, 0.003);
  EXPECT_NEAR(worst(*found, made.camera), 0.03, 0.02);
}

TEST(FoundVignetting, OnePictureIsRefusedUnlessTIsKnown) {
  const auto made = day(6, 3.0, 1);
  const auto refused = vignetting_from_sky(made.camera, made.moments);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::bad_input);
  EXPECT_THAT(refused.error().message, HasSubstr("1 picture with the sun in one place"));
  EXPECT_THAT(refused.error().message, testing::ContainsRegex("change the illumination at the rim by [0-9]+ %"));

  VignettingRequest known;
  known.turbidity = KnownTurbidity{3.0 + 0.2 * std::sin(6.0), 0.02};
  const auto found = must(vignetting_from_sky(made.camera, made.moments, known));
  EXPECT_LE(std::abs(worst(*found, made.camera)), 0.015);
  EXPECT_LE(found->by_3_percent_about_sun, 0.1);  // with T fitted it is several times that
}

TEST(FoundVignetting, ReportsThatThereIsNoClearSky) {
  auto made = day(7, 3.0, 2);
  for (auto& moment : made.moments)
    for (auto& value : moment.picture.encoded.elements()) value = glm::vec3(0.5f);
  EXPECT_THAT(vignetting_from_sky(made.camera, made.moments),
              FailsWith(HasSubstr("none of 2 pictures shows enough clear sky")));
}

}  // namespace
}  // namespace kasumi
