// Response curves from generated exposure stacks with curves known in closed form.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <random>

#include "base/units.hpp"
#include "calib/light/response_fit.hpp"
#include "calib/light/vignetting_fit.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

using Encode = std::function<double(double)>;  // light 0..1 to value 0..1

double linear(double light) {
  return light;
}
double srgb(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055;
}
// A toe below a five-hundredth, a shoulder above a third.
double film(double light) {
  const double above_toe = light * light / (light + 0.002) * 1.002;
  const double power = std::pow(above_toe, 0.9);
  return 1.3 * power / (power + 0.3);
}

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform() { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1.0p-53; }
  double normal() { return std::sqrt(-2.0 * std::log(uniform())) * std::cos(2.0 * kPi * uniform()); }

 private:
  std::mt19937_64 engine_;
};

// Shot and read noise of a sensor of 12000 electrons, 8 bits, clipped. `black`: encoded level without light.
std::vector<Image<glm::vec3>> stack(const Encode& encode, const std::vector<double>& exposures, std::uint64_t seed,
                                    double black = 0.0) {
  constexpr int kSide = 240;
  Random random(seed);
  std::vector<glm::dvec3> light;
  for (int i = 0; i < kSide * kSide; ++i) {
    // 14 stops from one side to the other, so that neighbouring pixels are similar.
    const double grey = std::exp(std::log(1e-4) + std::log(2e4) * (i % kSide + random.uniform()) / kSide);
    light.emplace_back(0.8 * grey, grey, 1.1 * grey);
  }
  std::vector<Image<glm::vec3>> pictures;
  for (const double exposure : exposures) {
    Image<glm::vec3> picture(kSide, kSide);
    for (std::size_t i = 0; i < light.size(); ++i)
      for (int c = 0; c < 3; ++c) {
        const double electrons = 12000.0 * exposure * light[i][c];
        const double noisy = (electrons + std::sqrt(electrons + 16.0) * random.normal()) / 12000.0;
        const double value = black + (1.0 - black) * encode(std::clamp(noisy, 0.0, 1.0));
        picture.elements()[i][c] = static_cast<float>(std::round(255.0 * std::clamp(value, 0.0, 1.0)) / 255.0);
      }
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

std::vector<double> doublings(int count) {
  std::vector<double> exposures;
  for (int j = 0; j < count; ++j) exposures.push_back(std::exp2(-0.5 * count + j));
  return exposures;
}

std::vector<double> logarithms(const std::vector<double>& exposures) {
  std::vector<double> logs;
  for (const double exposure : exposures) logs.push_back(std::log(exposure));
  return logs;
}

// The largest relative error of light over the 8 stops below saturation; the gain is free.
double worst_error(const ResponseFit& fit, const Encode& encode) {
  const auto response = Response::table(fit.light);
  double worst = 0.0;
  for (int c = 0; c < 3; ++c) {
    std::vector<double> ratios;
    for (double stops = 8.0; stops >= 0.0; stops -= 0.05) {
      const double light = std::exp2(-stops), value = encode(light);
      if (value < kSaturated) ratios.push_back(response.to_light(glm::dvec3(value))[c] / light);
    }
    auto sorted = ratios;
    std::sort(sorted.begin(), sorted.end());
    const double gain = sorted[sorted.size() / 2];
    for (const double ratio : ratios) worst = std::max(worst, std::abs(ratio / gain - 1.0));
  }
  return worst;
}

struct Case {
  const char* name;
  Encode encode;
};
class KnownCurve : public testing::TestWithParam<Case> {};

TEST_P(KnownCurve, IsFoundWithinOnePercentOverEightStops) {
  const auto exposures = doublings(11);
  const auto samples = sample_stack(stack(GetParam().encode, exposures, 1), 1.0 / 255.0, glm::dvec3(0.0), {}, 40000);
  const auto found = must(calibrate_response(samples, {logarithms(exposures), 0.0, true}));
  const double worst = worst_error(found->fit, GetParam().encode);
  std::printf("%s: %s, %.2f %% at worst over 8 stops, predicts to %.3f steps\n", GetParam().name,
              found->fit.method.c_str(), 100.0 * worst, found->held_out_steps);
  for (const auto& candidate : found->candidates)
    std::printf("    %-36s %.4f\n", candidate.method.c_str(), candidate.held_out_steps.value_or(-1.0));
  EXPECT_LE(worst, 0.01);
}

INSTANTIATE_TEST_SUITE_P(Response, KnownCurve,
                         testing::Values(Case{"linear", linear}, Case{"srgb", srgb}, Case{"film", film}),
                         [](const auto& given) { return std::string(given.param.name); });

TEST(ResponseFit, TheUnknownExposuresAndNoiseOfALinearCameraAreFound) {
  const std::vector exposures{1.0 / 40.0, 1.0 / 20.0, 1.0 / 8.0, 0.5, 1.0};
  const auto samples = sample_stack(stack(linear, exposures, 2), 1.0 / 255.0, glm::dvec3(0.0), {}, 8000);
  const auto order = by_brightness(samples);
  EXPECT_THAT(order, testing::ElementsAre(0, 1, 2, 3, 4));
  KnownExposures unknown{{0.0}, 0.0, false};
  for (const auto& ratio : linear_ratios(samples, order)) {
    ASSERT_TRUE(ratio);
    unknown.log_s.push_back(unknown.log_s.back() + std::log(*ratio));
  }
  const auto found = must(calibrate_response(samples, unknown));
  EXPECT_TRUE(found->fit.is_straight) << found->fit.method;
  for (std::size_t j = 1; j < exposures.size(); ++j)
    EXPECT_NEAR(std::exp(found->fit.log_s[j] - found->fit.log_s[j - 1]) / (exposures[j] / exposures[j - 1]), 1.0, 0.01);
  EXPECT_THAT(found->undetermined, testing::Contains(HasSubstr("power")));
  // 12000 electrons; medians of thousands of values, and a two-parameter fit to them.
  const auto noise = must(fit_noise(samples, found->fit));
  EXPECT_NEAR(noise->full_scale_electrons() / 12000.0, 1.0, 0.15);
}

TEST(ResponseFit, PicturesWithoutCommonPixelsAreRefused) {
  const auto samples = sample_stack(stack(linear, {1e-6, 1e6}, 3), 1.0 / 255.0, glm::dvec3(0.0), {}, 1000);
  EXPECT_FALSE(linear_ratios(samples, by_brightness(samples)).front());
  EXPECT_FALSE(calibrate_response(samples, {{std::log(1e-6), std::log(1e6)}, 0.0, true}));
}

TEST(VignettingFit, AFlatFieldWithDustRecoversTheLensWithinOnePercent) {
  const Vignetting truth{{101.0, 97.5}, 130.0, {-0.22, 0.05, -0.08}};
  Random random(4);
  std::vector<Image<float>> flats;
  for (const double gain : {0.5, 0.8}) {
    Image<float> flat(200, 200);
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 200; ++x) {
        const bool dust = std::hypot(x - 60.0, y - 140.0) < 12.0;
        flat.at(x, y) =
            static_cast<float>(gain * truth.at({x, y}) * (1.0 + 0.01 * random.normal()) * (dust ? 0.8 : 1.0));
      }
    flats.push_back(std::move(flat));
  }
  const auto found = must(fit_vignetting(flats, {}, truth.centre, truth.radius_px));
  for (double r = 0.0; r <= 130.0; r += 5.0) {
    const glm::dvec2 at = truth.centre + glm::dvec2{0.6 * r, 0.8 * r};
    EXPECT_NEAR(found->vignetting.at(at) / truth.at(at), 1.0, 0.01) << r;
  }
  EXPECT_NEAR(found->residual, 0.01, 0.001);
  // Vignetting that reaches zero is not a lens.
  for (auto& flat : flats)
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 200; ++x)
        flat.at(x, y) = std::max(1e-4f, 1.0f - static_cast<float>(std::hypot(x - 101, y - 97)) / 90.0f);
  EXPECT_FALSE(fit_vignetting(flats, {}, truth.centre, truth.radius_px));
}

}  // namespace
}  // namespace kasumi
