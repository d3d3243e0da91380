// What is no stack of exposures of one view is refused, with the pictures and values named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "calib/light/one_view.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr int kViewSide = 192;

// A gradient with bumps by a seed, in 8 bits, under a gamma and noise of `steps`.
Image<glm::vec3> exposure_of(unsigned view, double exposure, double steps, unsigned seed) {
  std::mt19937 bumps(view), random(seed);
  std::uniform_real_distribution<double> uniform;
  std::normal_distribution<double> noise;
  std::vector<glm::dvec3> places;  // centre, width
  for (int i = 0; i < 12; ++i)
    places.emplace_back(uniform(bumps) * kViewSide, uniform(bumps) * kViewSide, 15.0 + 20.0 * uniform(bumps));
  Image<glm::vec3> made(kViewSide, kViewSide);
  for (int y = 0; y < kViewSide; ++y)
    for (int x = 0; x < kViewSide; ++x) {
      double log_light = -2.5;
      for (const auto& place : places)
        log_light += 1.5 * std::exp(-0.5 * (std::pow(x - place.x, 2) + std::pow(y - place.y, 2)) / (place.z * place.z));
      const double value = 255.0 * std::pow(std::min(1.0, exposure * std::exp(log_light)), 1.0 / 2.2);
      made.at(x, y) =
          glm::vec3(static_cast<float>(std::round(std::clamp(value + steps * noise(random), 0.0, 255.0)) / 255.0));
    }
  return made;
}

ExposureStack stack_of(const std::vector<unsigned>& views, double steps) {
  ExposureStack stack;
  stack.quantum = 1.0 / 255.0;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const double exposure = std::exp2(static_cast<double>(k) - 0.5 * static_cast<double>(views.size()));
    stack.pictures.push_back(exposure_of(views[k], exposure, steps, static_cast<unsigned>(k) + 100));
    stack.names.push_back(fmt::format("e{}.png", k));
    stack.log_s.push_back(std::log(exposure));
  }
  return stack;
}

TEST(OneView, ExposuresOfAStillViewPassInSpiteOfNoise) {
  for (const double steps : {0.0, 2.0, 5.0}) {
    const auto checked = check_one_view(stack_of({1, 1, 1, 1, 1, 1}, steps), {});
    EXPECT_TRUE(checked) << steps << ": " << checked.error().message;
  }
}

TEST(OneView, APictureOfAnotherViewIsNamedAndNoOther) {
  const auto checked = check_one_view(stack_of({1, 1, 1, 2, 1, 1}, 1.0), {});
  ASSERT_FALSE(checked);
  EXPECT_EQ(checked.error().kind, FaultKind::bad_input);
  const auto& told = checked.error().message;
  EXPECT_THAT(told, HasSubstr("1 of the 6 pictures"));
  EXPECT_THAT(told, HasSubstr("\ne3.png: at best "));
  for (const char* other : {"\ne0.png", "\ne1.png", "\ne2.png", "\ne4.png", "\ne5.png"})
    EXPECT_THAT(told, Not(HasSubstr(other)));
}

TEST(OneView, WhereNoTwoAgreeAllAreNamed) {
  const auto checked = check_one_view(stack_of({1, 2, 3, 4}, 1.0), {});
  ASSERT_FALSE(checked);
  for (const char* each : {"4 of the 4 pictures", "\ne0.png", "\ne1.png", "\ne2.png", "\ne3.png"})
    EXPECT_THAT(checked.error().message, HasSubstr(each));
}

// A wall: its levels are in no order but noise's, and yet it is one view.
TEST(OneView, AViewWithoutContrastIsNoOtherView) {
  ExposureStack stack;
  stack.names = {"a.png", "b.png"};
  std::mt19937 random(3);
  std::normal_distribution<float> noise;
  for (const float level : {60.0f, 120.0f}) {
    Image<glm::vec3> wall(kViewSide, kViewSide);
    for (auto& pixel : wall.elements()) pixel = glm::vec3(std::round(level + 2.0f * noise(random)) / 255.0f);
    stack.pictures.push_back(std::move(wall));
  }
  const auto agreement = must(compare_views(stack.pictures[0], stack.pictures[1], {}));
  EXPECT_LT(agreement->rank_correlation, 0.2);
  EXPECT_LT(agreement->residual_steps, 2.0);
  EXPECT_TRUE(check_one_view(stack, {}));
}

TEST(OneView, OutsideTheMaskNothingIsCompared) {
  auto stack = stack_of({1, 1, 1}, 1.0);
  const auto other = exposure_of(2, 0.5, 1.0, 7);
  Image<std::uint8_t> mask(kViewSide, kViewSide, 255);
  for (int y = 0; y < kViewSide; ++y)
    for (int x = kViewSide / 2; x < kViewSide; ++x) {
      stack.pictures[1].at(x, y) = other.at(x, y);
      mask.at(x, y) = 0;
    }
  EXPECT_FALSE(check_one_view(stack, {}));
  EXPECT_TRUE(check_one_view(stack, mask));
}

TEST(ExposureRatios, ThatAreAllOneSayNothing) {
  KnownStack known;
  known.stack.names = {"a.png", "b.png", "c.png"};
  known.stack.log_s = {std::log(0.01), std::log(0.01), std::log(0.0103)};
  known.exposures.known = true;
  EXPECT_THAT(check_exposure_ratios(known), FailsWith(HasSubstr("a.png 1.000, b.png 1.000, c.png 1.030")));
  known.stack.log_s.back() = std::log(0.02);
  EXPECT_TRUE(check_exposure_ratios(known));
}

TEST(Prediction, WorseThanThreeStepsIsRefusedWithItsFigureAndTheWorstPicture) {
  KnownStack known;
  known.stack = stack_of({1, 1, 1, 1}, 0.5);
  for (auto& pixel : known.stack.pictures[2].elements()) pixel *= 0.7f;  // a cloud before the sun
  known.exposures = {known.stack.log_s, 0.0, true};
  const auto samples = sample_stack(known.stack.pictures, known.stack.quantum, glm::dvec3(0.0), {}, 3000);
  auto calibration = must(calibrate_response(samples, known.exposures));
  const auto checked = check_prediction(*calibration, samples, known);
  ASSERT_FALSE(checked) << calibration->held_out_steps;
  EXPECT_THAT(checked.error().message,
              HasSubstr(fmt::format("predicts the pictures to {:.1f} steps", calibration->held_out_steps)));
  EXPECT_THAT(checked.error().message, HasSubstr("worst in e"));
  // Steps of 16 bits are smaller.
  auto fine = samples;
  fine.quantum = 1.0 / 65535.0;
  calibration->held_out_steps = 700.0;
  EXPECT_TRUE(check_prediction(*calibration, fine, known));
  calibration->held_out_steps = 800.0;
  EXPECT_FALSE(check_prediction(*calibration, fine, known));
}

}  // namespace
}  // namespace kasumi
