// A photograph under other air, against M Eq 25 and 26 for every pixel.
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "estimator/photograph/other_air.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

constexpr int kWidth = 12, kHeight = 8;
const glm::dvec3 kAirlight{0.55, 0.6, 0.7};  // linear

// Rows from the sky (0) down to the land, all at the same distance.
Photograph colourful() {
  Photograph photograph;
  photograph.encoded = Image<glm::vec3>(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      photograph.encoded.at(x, y) = {0.40F + 0.03F * static_cast<float>(x), 0.75F - 0.02F * static_cast<float>(y),
                                     0.60F + 0.02F * static_cast<float>(x)};
  return photograph;
}

SourceConditions options_for(const AirState& source) {
  SourceConditions options;
  options.camera = plain_camera(kWidth, kHeight, from_degrees(40.0), Radians{0.0});
  options.source = source;
  options.airlight = kAirlight;
  options.distance_m = Image<float>(kWidth, kHeight, 4000.0F);
  for (int x = 0; x < kWidth; ++x) options.distance_m.at(x, 0) = 0.0F;
  options.amplify_noise = true;  // the picture is not denoised
  return options;
}

Photograph under(const Photograph& photograph, const AirState& source, const std::optional<AirState>& target) {
  OtherAir air(options_for(source));
  const auto picture_set = air.set_picture(photograph, "picture");
  EXPECT_TRUE(picture_set) << picture_set.error().message;
  return air.under(target).picture;
}

double largest_difference(const Photograph& one, const Photograph& other) {
  double largest = 0.0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const glm::dvec3 off = glm::abs(one.encoded.at(x, y) - other.encoded.at(x, y));
      largest = std::max({largest, off.r, off.g, off.b});
    }
  return largest;
}

TEST(OtherAir, UnderItsOwnAirAPictureStaysUnchanged) {
  EXPECT_LE(largest_difference(under(colourful(), Turbidity{3.0}, Turbidity{3.0}), colourful()), 1e-5);
}

TEST(OtherAir, ThickerAirBringsEachChannelTowardsTheAirlightByOneShare) {
  const auto camera = options_for(Turbidity{2.0}).camera;
  const auto before = colourful(), after = under(before, Turbidity{2.0}, Turbidity{4.0});
  const auto share_at = [&](int x, int y) {
    const glm::dvec3 from = camera.light_at({x, y}, glm::dvec3(before.encoded.at(x, y)));
    return (camera.light_at({x, y}, glm::dvec3(after.encoded.at(x, y))) - kAirlight) / (from - kAirlight);
  };
  const auto share = share_at(0, 4);
  for (const int x : {2, 6, 11})
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(share_at(x, 4)[c], share[c], 2e-3) << x << ", channel " << c;
  for (int c = 0; c < 3; ++c) EXPECT_TRUE(share[c] > 0.2 && share[c] < 0.95) << share[c];
  EXPECT_GT(share.r, share.b) << "air passes red light better";
  EXPECT_NEAR(share_at(6, 0).r, 1.0, 1e-3) << "the sky keeps its ratio to the light from infinity";
}

TEST(OtherAir, KnownDustTakesAllColoursNearlyAlike) {
  const auto dust = [](double aod) {
    return AirState(Aerosol{aod, natural_exponent(AerosolKind::dust), AerosolKind::dust});
  };
  const auto camera = options_for(dust(0.1)).camera;
  const auto before = colourful(), after = under(before, dust(0.1), dust(0.4));
  const glm::dvec3 from = camera.light_at({2, 4}, glm::dvec3(before.encoded.at(2, 4)));
  const glm::dvec3 share =
      (camera.light_at({2, 4}, glm::dvec3(after.encoded.at(2, 4))) - kAirlight) / (from - kAirlight);
  const double rise_m = 4000.0 * camera.direction_at({2, 4})->z;
  EXPECT_NEAR(share.g, std::exp(-0.3 / 1200.0 * optical_path(0.0, rise_m, 4000.0).mie_m), 0.005);
  EXPECT_NEAR(share.r / share.b, 1.0, 0.06);
  EXPECT_LT(share.r, share.b) << "and a little more of the red";
  EXPECT_LE(largest_difference(under(after, dust(0.4), dust(0.1)), before), 1e-3) << "there and back";
}

TEST(OtherAir, ThereAndBackGivesTheOriginal) {
  const auto thicker = under(colourful(), Turbidity{2.0}, Turbidity{3.5});
  EXPECT_GT(largest_difference(thicker, colourful()), 0.02);
  EXPECT_LE(largest_difference(under(thicker, Turbidity{3.5}, Turbidity{2.0}), colourful()), 1e-4);
}

// M Fig 11: what the air scatters in, and what is left of the scene.
TEST(OtherAir, ItsTermsAddUpToThePictureInLinearLight) {
  auto options = options_for(Turbidity{2.0});
  options.terms = true;
  OtherAir air(options);
  ASSERT_TRUE(air.set_picture(colourful(), "picture"));
  const auto hazy = air.under(Turbidity{4.0}), clear = air.under(std::nullopt);
  ASSERT_TRUE(hazy.airlight && hazy.direct && clear.airlight);
  const auto light = [&](const Photograph& of, int x, int y) {
    return options.camera.light_at({x, y}, glm::dvec3(of.encoded.at(x, y)));
  };
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const auto airlight = light(*hazy.airlight, x, y), direct = light(*hazy.direct, x, y);
      const auto whole = light(hazy.picture, x, y), without_air = light(clear.picture, x, y);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(airlight[c] + direct[c], whole[c], 1e-5) << x << ", " << y;
        if (y == 0) {
          EXPECT_NEAR(airlight[c], whole[c], 1e-5) << "the sky is all airlight";
          continue;
        }
        EXPECT_GT(airlight[c], 0.05);
        EXPECT_NEAR(direct[c], (1.0 - airlight[c] / kAirlight[c]) * without_air[c], 1e-4)
            << "the scene without air, attenuated by what the airlight says";
        EXPECT_NEAR(light(*clear.airlight, x, y)[c], 0.0, 1e-9);
      }
    }
  OtherAir unasked(options_for(Turbidity{2.0}));
  ASSERT_TRUE(unasked.set_picture(colourful(), "picture"));
  EXPECT_FALSE(unasked.under(Turbidity{4.0}).airlight);
}

TEST(OtherAir, ReportsWhatCannotBeDone) {
  auto options = options_for(Turbidity{2.0});
  Photograph small;
  small.encoded = Image<glm::vec3>(3, 2);
  EXPECT_THAT(OtherAir(options).set_picture(small, "small.png"),
              FailsWith(HasSubstr("small.png: is 3 x 2: expected 12 x 8")));
  options.airlight.reset();
  Photograph dark;
  dark.encoded = Image<glm::vec3>(kWidth, kHeight, glm::vec3(0.0F));
  EXPECT_THAT(OtherAir(options).set_picture(dark, "dark.png"),
              FailsAs(FaultKind::bad_input, HasSubstr("dark.png: no horizon")));
}

}  // namespace
}  // namespace kasumi
