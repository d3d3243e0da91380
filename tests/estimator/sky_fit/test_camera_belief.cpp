#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "estimator/sky_fit/camera_belief.hpp"

namespace kasumi {
namespace {

TEST(CameraBelief, StaysWhereNoPictureSaysAnything) {
  const CameraBelief before;
  const auto after = belief_after({});
  EXPECT_EQ(after.log_exponent, before.log_exponent);
  EXPECT_EQ(after.sigma_log_exponent, before.sigma_log_exponent);
  // A picture that is no surer than the belief it was asked under says nothing.
  const std::vector nothing{ToneSight{1.0, before.sigma_log_exponent}};
  EXPECT_NEAR(belief_after(nothing).sigma_log_exponent, before.sigma_log_exponent, 1e-12);
}

TEST(CameraBelief, APictureThatIsAskedAgainUnderItsOwnBeliefIsNotCountedTwice) {
  // exp(.3) +- 20 %, half from the prior 0 +- 35 %: by itself it says more.
  const std::vector one{ToneSight{std::exp(0.3), 0.2 * std::exp(0.3)}};
  const auto after = belief_after(one);
  const double own = 1.0 / (0.2 * 0.2) - 1.0 / (0.35 * 0.35);
  const double mean = 0.3 / (0.2 * 0.2) / own;
  const double share = 1.0 / (1.0 / own + 0.1 * 0.1);
  EXPECT_NEAR(after.log_exponent, share * mean / (share + 1.0 / (0.35 * 0.35)), 1e-12);
}

TEST(CameraBelief, ManyPicturesAreNeverCertain) {
  const std::vector<ToneSight> many(1000, ToneSight{1.5, 0.1});
  const auto after = belief_after(many);
  EXPECT_NEAR(std::exp(after.log_exponent), 1.55, 0.06);  // without the prior's pull
  EXPECT_GE(after.sigma_log_exponent, 0.05);
  EXPECT_LE(after.sigma_log_exponent, 0.06);
}

}  // namespace
}  // namespace kasumi
