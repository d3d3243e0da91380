// Cloud fraction and sky class of drawn pictures, one a kind of sky or camera.
#include <gtest/gtest.h>

#include "estimator/cloud_cover/cloud_cover.hpp"
#include "tests/estimator/cloud_cover/drawn_skies.hpp"

namespace kasumi {
namespace {

CloudCover cover_of(const DrawnSky& sky, bool sun_known = true) {
  const Camera camera = camera_looking_up();
  return cloud_cover(drawn(sky, camera), camera, sun_known ? std::optional(drawn_sun()) : std::nullopt);
}

// Clouds over the azimuths below `degrees`.
DrawnSky clouds_below(double degrees) {
  return [=](double zenith, double azimuth) {
    return azimuth < degrees ? cloud(zenith, azimuth) : clear_sky(zenith, azimuth);
  };
}

// Clouds over the side without the sun.
glm::vec3 half_clouded(double zenith, double azimuth) {
  return azimuth > 180.0 ? cloud(zenith, azimuth) : clear_sky(zenith, azimuth);
}

void expect_near(const CloudCover& cover, double fraction, double tolerance) {
  ASSERT_TRUE(cover.fraction) << cover.reason;
  EXPECT_NEAR(*cover.fraction, fraction, tolerance);
  EXPECT_LT(std::abs(*cover.fraction - fraction), 2.5 * cover.sigma);
}

TEST(CloudCover, AClearSkyIsClearInSpiteOfItsWhiteHorizonAndTheSunsGlow) {
  for (const bool sun_known : {true, false}) {
    const CloudCover cover = cover_of(clear_sky, sun_known);
    expect_near(cover, 0.0, 0.06);
    EXPECT_EQ(cover.sky, CoverClass::clear);
  }
}

TEST(CloudCover, AHalfCloudedSkyIsBroken) {
  const CloudCover cover = cover_of(half_clouded);
  expect_near(cover, 0.5, 0.08);
  EXPECT_EQ(cover.sky, CoverClass::broken);
  EXPECT_GT(cover.confidence, 0.8);
}

TEST(CloudCover, TheElementsTellWhereTheCloudsAre) {
  const CloudCover cover = cover_of(half_clouded);
  const Camera camera = camera_looking_up();
  const auto at = [&](double azimuth) {
    const auto pixel = *camera.pixel_of(direction_from(from_degrees(40.0), from_degrees(azimuth)));
    return cover.elements.at(static_cast<int>(pixel.x), static_cast<int>(pixel.y));
  };
  EXPECT_EQ(at(270.0), CoverElement::cloud);
  EXPECT_EQ(at(60.0), CoverElement::clear);
  EXPECT_EQ(cover.elements.at(0, 0), CoverElement::not_sky);
}

TEST(CloudCover, AnEighthOfCloudIsFew) {
  const CloudCover cover = cover_of(clouds_below(50.0));
  expect_near(cover, 50.0 / 360.0, 0.06);
  EXPECT_EQ(cover.sky, CoverClass::few);
}

TEST(CloudCover, AGreySkyIsOvercast) {
  const CloudCover cover = cover_of(cloud, false);
  expect_near(cover, 1.0, 0.05);
  EXPECT_EQ(cover.sky, CoverClass::overcast);
}

TEST(CloudCover, AWarmOrCoolWhiteBalanceChangesLittle) {
  for (const float gain : {0.94f, 1.06f}) {
    const CloudCover cover = cover_of([=](double zenith, double azimuth) {
      return half_clouded(zenith, azimuth) * glm::vec3(gain, 1.0f, 1.0f / gain);
    });
    expect_near(cover, 0.5, 0.12);
    EXPECT_EQ(cover.sky, CoverClass::broken);
  }
}

TEST(CloudCover, AWallAndATreeAreNoCloud) {
  const CloudCover cover = cover_of([](double zenith, double azimuth) {
    if (azimuth > 200.0 && azimuth < 260.0 && zenith > 40.0) return glm::vec3(0.45f, 0.44f, 0.42f);
    if (azimuth > 300.0 && azimuth < 340.0 && zenith > 60.0) return glm::vec3(0.14f, 0.22f, 0.08f);
    return clear_sky(zenith, azimuth);
  });
  expect_near(cover, 0.0, 0.08);
  EXPECT_EQ(cover.sky, CoverClass::clear);
}

TEST(CloudCover, ADarkPictureIsNight) {
  const CloudCover cover = cover_of([](double, double) { return glm::vec3(0.012f); }, false);
  EXPECT_FALSE(cover.fraction);
  EXPECT_EQ(cover.sky, CoverClass::night);
}

TEST(CloudCover, CloudsLitByLampsAreNight) {
  const CloudCover cover = cover_of(
      [](double zenith, double azimuth) { return cloud(zenith, azimuth) * glm::vec3(0.45f, 0.36f, 0.24f); }, false);
  EXPECT_FALSE(cover.fraction);
  EXPECT_EQ(cover.sky, CoverClass::night);
}

TEST(CloudCover, WithoutAChannelNothingIsKnown) {
  const CloudCover cover =
      cover_of([](double zenith, double azimuth) { return clear_sky(zenith, azimuth) * glm::vec3(0.02f, 1.0f, 1.0f); });
  EXPECT_FALSE(cover.fraction);
  EXPECT_EQ(cover.sky, CoverClass::unknown);
  EXPECT_NE(cover.reason.find("channel"), std::string::npos) << cover.reason;
  EXPECT_EQ(cover.confidence, 0.0);
}

TEST(CloudCover, AGreyCameraDoesNotKnow) {
  const Camera camera = camera_looking_up();
  SkyPicture picture = drawn(clouds_below(180.0), camera);
  for (glm::vec3& v : picture.encoded.elements()) v = glm::vec3(v.g);
  const CloudCover cover = cloud_cover(picture, camera);
  EXPECT_FALSE(cover.fraction);
  EXPECT_EQ(cover.sky, CoverClass::unknown);
}

TEST(CloudCover, AnOverExposedPictureIsNotKnownOrSaysSo) {
  const CloudCover all_white = cover_of([](double, double) { return glm::vec3(1.1f); });
  EXPECT_FALSE(all_white.fraction);
  const CloudCover half = cover_of([](double zenith, double azimuth) { return clear_sky(zenith, azimuth) * 1.6f; });
  ASSERT_TRUE(half.fraction) << half.reason;
  EXPECT_LT(*half.fraction, 2.5 * half.sigma);
}

TEST(CloudCover, APaleSkyWhoseBlueIsClippedAllOverIsClear) {
  const CloudCover cover = cover_of([](double zenith, double azimuth) {
    const glm::vec3 seen = clear_sky(zenith, azimuth);
    return glm::vec3(seen.r + 0.34f, seen.g + 0.36f, 1.1f);
  });
  ASSERT_TRUE(cover.fraction) << cover.reason;
  EXPECT_LT(*cover.fraction, 0.2);
}

TEST(CloudCover, AMaskThatHidesAllLeavesNothingToJudge) {
  Camera camera = camera_looking_up();
  const SkyPicture picture = drawn(clear_sky, camera);
  camera.mask = Image<std::uint8_t>(camera.width, camera.height, 0);
  const CloudCover cover = cloud_cover(picture, camera);
  EXPECT_FALSE(cover.fraction);
  EXPECT_EQ(cover.sky, CoverClass::unknown);
}

}  // namespace
}  // namespace kasumi
