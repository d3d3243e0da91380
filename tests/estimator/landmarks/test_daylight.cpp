// Pictures by night and in infrared light say nothing of visibility; grey fog by day does.
#include "estimator/landmarks/daylight.hpp"

#include <gtest/gtest.h>

#include "fixtures/noise/random.hpp"
#include "tests/estimator/landmarks/generated_landmarks.hpp"

namespace kasumi {
namespace {

fixtures::Weather weather_under(const SunPlace& sun, double turbidity, double cover = 0.0) {
  fixtures::Weather weather;
  weather.turbidity = turbidity;
  weather.sun = direction_from(from_degrees(sun.zenith_deg), from_degrees(sun.azimuth_deg));
  weather.altitude_m = kValley_m;
  weather.cloud_cover = cover;
  return weather;
}

const GeneratedView& the_view() {
  static const auto view = generated_view(21);
  return view;
}

// What an infrared camera makes of it: one channel for all, leaves as bright as they are there, the gain turned up.
Image<glm::vec3> infrared(Image<glm::vec3> encoded, double noise, std::uint64_t seed) {
  fixtures::Random random(seed);
  for (auto& pixel : encoded.elements()) {
    const float grey = 0.4F * pixel.r + 0.4F * pixel.g + 0.2F * pixel.b;
    const auto noisy = static_cast<float>(static_cast<double>(grey) + noise * random.normal());
    pixel = glm::vec3(std::round(255.0F * std::clamp(noisy, 0.0F, 1.0F)) / 255.0F);
  }
  return encoded;
}

std::string why_not(const Image<glm::vec3>& encoded) {
  return why_not_daylight(look_for_daylight(encoded));
}

TEST(Daylight, DaysAreDays) {
  std::uint64_t seed = 0;
  for (const double zenith : {30.0, 75.0, 84.0})
    for (const double turbidity : {1.7, 9.0})
      for (const double cover : {0.0, 1.0}) {
        const auto encoded = encoded_in(the_view(), weather_under({zenith, 100.0}, turbidity, cover), ++seed);
        EXPECT_EQ(why_not(encoded), "") << zenith << " deg, T " << turbidity << ", clouds " << cover;
      }
}

TEST(Daylight, GreyFogByDayIsNoInfraredPicture) {
  auto weather = weather_under({60.0, 100.0}, 3.0, 1.0);
  for (const double per_m : {0.002, 0.03}) {
    weather.fog = {per_m, kValley_m - 100.0, 1e4};
    const auto encoded = encoded_in(the_view(), weather, 7);
    EXPECT_EQ(why_not(encoded), "") << per_m;
    // Without a trace of colour, as an automatic white balance and JPEG's coarse colours may leave it.
    if (per_m > 0.01) {
      EXPECT_EQ(why_not(infrared(encoded, 0.0, 1)), "") << per_m;
    }
  }
}

TEST(Daylight, NightHasNoiseOrLampsOrDarkness) {
  EXPECT_NE(why_not(encoded_in(the_view(), weather_under({97.0, 250.0}, 3.0), 3)), "");
  const auto day = encoded_in(the_view(), weather_under({60.0, 250.0}, 3.0), 4);
  ASSERT_EQ(why_not(day), "");
  EXPECT_NE(why_not_daylight(look_for_daylight(day), direction_from(from_degrees(91.0), from_degrees(250.0))), "")
      << "the sun is known to be below the horizon";
  EXPECT_EQ(why_not_daylight(look_for_daylight(day), direction_from(from_degrees(80.0), from_degrees(250.0))), "");
  // With all its gain.
  auto noisy = day;
  fixtures::Random random(5);
  for (auto& pixel : noisy.elements())
    for (int c = 0; c < 3; ++c) pixel[c] += static_cast<float>(6.0 / 255.0 * random.normal());
  EXPECT_NE(why_not(noisy).find("noise"), std::string::npos) << why_not(noisy);
  // Windows and street lamps below a sky that glows of the town.
  auto town = day;
  for (auto& pixel : town.elements()) pixel *= 0.4F;
  for (int k = 0; k < 12; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) town.at(20 + 24 * k + i, 140 + j) = glm::vec3(1.0F, 1.0F, 0.8F);
  EXPECT_NE(why_not(town).find("lamps"), std::string::npos) << why_not(town);
}

TEST(Daylight, InfraredHasNoColours) {
  const auto day = encoded_in(the_view(), weather_under({60.0, 250.0}, 3.0), 4);
  for (const double noise : {0.0, 2.0, 7.0})
    EXPECT_NE(why_not(infrared(day, noise / 255.0, 1)).find("infrared"), std::string::npos) << noise;
}

TEST(Daylight, NoLandmarkIsReadInAnInfraredPicture) {
  const auto& view = the_view();
  const LandmarkWatch watch(view.camera.camera, kValley_m, view.landmarks);
  const auto day = encoded_in(view, weather_under({60.0, 250.0}, 3.0), 4);
  EXPECT_EQ(watch.estimate(watch.read(view.camera.camera, day)).extinction().kind, ExtinctionKind::value);
  const auto air = watch.estimate(watch.read(view.camera.camera, infrared(day, 0.02, 1)));
  EXPECT_EQ(air.extinction().kind, ExtinctionKind::nothing);
  EXPECT_EQ(air.aerosol.kind, ExtinctionKind::nothing);
  EXPECT_NE(air.extinction().reason.find("infrared"), std::string::npos) << air.extinction().reason;
}

}  // namespace
}  // namespace kasumi
