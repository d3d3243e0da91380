// A camera's tone curve from several of its pictures of cloudless skies, which no fit has seen.
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "estimator/sky_fit/tone_curve.hpp"
#include "estimator/turbidity/turbidity.hpp"
#include "tests/estimator/turbidity/sky_population.hpp"
#include "tests/estimator/turbidity/strange_camera.hpp"
#include "tests/figures.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using test::Population;

constexpr int kToneSide = 240;

// As a linear picture; the camera encodes light^exponent.
ToneEvidence taken(const test::PopulationSky& sky, double exponent, std::uint64_t seed) {
  test::StrangeCamera camera = test::plain_camera(seed);
  camera.curve = test::StrangeCamera::Curve::power;
  camera.strength = exponent;
  camera.white_balance = 0.5;
  Camera believed = test::believed_camera(kToneSide);
  believed.response = Response::linear();
  EstimateParameters options;
  options.sky.every_model = true;
  options.sky.altitude_m = test::kPopulationAltitude_m;
  const Image<Rgb8> picture = test::photograph(sky, camera, kToneSide);
  return {SkyObserver(believed).observe(*sky_picture(view_of(picture), believed), sky.sun, options).readings, sky.sun};
}

// The skies in groups of `pictures`, each taken by a camera of its own.
void expect_found(const std::vector<test::PopulationSky>& skies, std::size_t pictures, const std::string& what) {
  const std::vector<double> exponents{1.0 / 2.2, 0.8, 1.0, 1.0 / 1.6, 1.25};
  int cameras = 0, refused = 0, covered = 0;
  double squares = 0.0;
  for (std::size_t first = 0; first + pictures <= skies.size(); first += pictures) {
    const double exponent = exponents[first / pictures % exponents.size()];
    std::vector<ToneEvidence> of_camera;
    for (std::size_t i = first; i < first + pictures; ++i) of_camera.push_back(taken(skies[i], exponent, 70 + i));
    const auto curve = find_tone_curve(of_camera, test::kPopulationAltitude_m);
    ++cameras;
    if (!curve) {
      std::printf("  %s\n", curve.error().message.c_str());
      ++refused;
      continue;
    }
    const double off = curve->exponent - exponent;
    std::printf("  exponent %.3f: %.3f +- %.3f, off by %.1f %%\n", exponent, curve->exponent, curve->sigma,
                100.0 * curve->log_residual);
    squares += off * off;
    if (std::abs(off) < 2.0 * curve->sigma) ++covered;
  }
  const int found = cameras - refused;
  std::printf("%s: %d cameras, %zu pictures each: %d refused, exponent off by %.3f (rms), %d of %d within 2 sigma\n",
              what.c_str(), cameras, pictures, refused, std::sqrt(squares / std::max(1, found)), covered, found);
  EXPECT_GE(covered, 0.9 * found);
  EXPECT_GE(found, 0.5 * cameras);
  EXPECT_LT(std::sqrt(squares / std::max(1, found)), 0.1);
}

int cameras() {
  return figure_cases("cameras", std::vector<int>{3}, std::vector<int>{12}).front();
}

TEST(AirTruthTone, IsFoundFromFourSpectralSkies) {
  expect_found(test::cloudless_skies(Population::development, 4 * cameras(), ""), 4, "spectral skies, development");
}

TEST(AirTruthTone, IsFoundFromFourOtherSkies) {
  expect_found(test::cloudless_skies(Population::held_out, 4 * cameras(), ""), 4, "spectral skies, held out");
}

TEST(AirTruthTone, IsFoundFromTwoSkies) {
  for (const Population population : {Population::development, Population::held_out})
    expect_found(test::cloudless_skies(population, 2 * cameras(), ""), 2, "spectral skies");
}

TEST(AirTruthTone, IsFoundFromFiveMeasuredSkies) {
  auto skies = test::cloudless_skies(Population::held_out, 0, (shared_data_folder() / "sky" / "cornell").string());
  if (skies.empty()) GTEST_SKIP() << "no shared data";
  // Each with suns of either end of the morning.
  std::vector<test::PopulationSky> mixed;
  for (std::size_t i = 0; i < skies.size() / 2; ++i) mixed.push_back(skies[2 * i]);
  for (std::size_t i = 0; i < skies.size() / 2; ++i) mixed.push_back(skies[2 * i + 1]);
  expect_found(mixed, 5, "measured skies");
}

TEST(AirTruthTone, IsNotFoundFromOnePicture) {
  const auto skies = test::cloudless_skies(Population::development, 1, "");
  const std::vector<ToneEvidence> one{taken(skies.front(), 1.0, 1)};
  const auto curve = find_tone_curve(one, test::kPopulationAltitude_m);
  ASSERT_FALSE(curve);
  EXPECT_NE(curve.error().message.find("at least two"), std::string::npos) << curve.error().message;
}

TEST(ToneCurve, IsUndoneByTheCorrectedResponse) {
  for (const double exponent : {0.5, 0.9, 1.7}) {
    const Response response = corrected(Response::srgb(), exponent);
    for (const double level : {0.2, 0.5, 0.9}) {
      const double as_read = Response::srgb().to_light(glm::dvec3{level}).x;
      EXPECT_NEAR(response.to_light(glm::dvec3{level}).x, std::pow(as_read, 1.0 / exponent), 1e-4);
    }
  }
}

}  // namespace
}  // namespace kasumi
