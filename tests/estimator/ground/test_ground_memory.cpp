// A place's brightness through days, from a reflectance and a sun that comes and goes. World: simulated.
#include <cmath>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "estimator/ground/ground_memory.hpp"

namespace kasumi {
namespace {

constexpr double kDay_s = 86400.0;

// Sun and sky on level ground `hour` after sunrise of a twelve-hour day; any unit.
GroundSight light_at(double hour) {
  const double high = std::sin(3.14159265 * hour / 12.0);
  return {0.0f, static_cast<float>(40.0 * high * std::exp(-0.15 / std::max(high, 0.05))),
          static_cast<float>(2.0 + 4.0 * high), 0.01f};
}

class Ground {
 public:
  Ground(double reflectance, double supposed, double noise = 0.0)
      : reflectance_(reflectance), noise_(noise), memory_(std::vector<float>{static_cast<float>(supposed)}) {}
  // The share of the sun's light that reaches it.
  const GroundGuess& see(double day, double hour, double sunlit) {
    GroundSight sight = light_at(hour);
    std::normal_distribution<double> noise(1.0, noise_ > 0.0 ? noise_ : 1e-9);
    sight.radiance =
        static_cast<float>(reflectance_ * noise(random_) * (sunlit * double(sight.sun) + double(sight.sky)));
    memory_.see({&sight, 1}, day * kDay_s + hour * 3600.0);
    return memory_.guesses()[0];
  }
  void see_day(double day, double from_hour, double to_hour, double sunlit) {
    for (double hour = from_hour; hour < to_hour; hour += 1.0 / 12.0) see(day, hour, sunlit);
  }
  const GroundMemory& memory() const { return memory_; }
  bool resume(const std::vector<std::uint8_t>& learnt, double since_s) { return memory_.resume(learnt, since_s); }

 private:
  double reflectance_, noise_;
  std::mt19937 random_{1};
  GroundMemory memory_;
};

TEST(GroundMemory, KnowsSunFromShadeWhateverItWasToldOfTheGround) {
  double worst = 0.0;
  for (const double reflectance : {0.05, 0.18, 0.5})
    for (const double factor : {0.4, 1.0, 2.5}) {
      Ground ground(reflectance, std::min(reflectance * factor, 1.0), 0.02);
      ground.see_day(0, 1.0, 10.5, 1.0);
      EXPECT_NEAR(ground.memory().reflectance(0) / reflectance, 1.0, 0.05) << reflectance << " told as x " << factor;
      for (const double sunlit : {1.0, 0.0, 0.5}) {
        const GroundGuess guess = ground.see(0, 10.6 + 0.1 * (1.0 - sunlit), sunlit);
        fmt::print("reflectance {:.2f}, told {:.3f}: sun {:.2f}, found {:.3f} +- {:.3f}\n", reflectance,
                   reflectance * factor, sunlit, double(guess.sunlit), double(guess.sigma));
        worst = std::max(worst, std::abs(double(guess.sunlit) - sunlit));
      }
    }
  EXPECT_LE(worst, 0.12);
}

TEST(GroundMemory, KnowsGroundThatLiesInTheShadeHalfOfTheDay) {
  Ground ground(0.2, 0.15, 0.02);
  for (int day = 0; day < 3; ++day) {
    ground.see_day(day, 1.0, 6.0, 1.0);
    ground.see_day(day, 6.0, 11.0, 0.0);
  }
  EXPECT_GE(ground.see(3, 2.0, 1.0).sunlit, 0.95f);
  EXPECT_LE(ground.see(3, 9.0, 0.0).sunlit, 0.05f);
}

// Dark ground in the sun or pale ground in the shade: nobody can know at first sight, and the shadow is to be pale.
TEST(GroundMemory, SaysThatItDoesNotKnow) {
  Ground ground(0.12, 0.1);
  const GroundGuess first = ground.see(0, 11.0, 0.0);
  fmt::print("at first sight: {:.2f} +- {:.2f}\n", double(first.sunlit), double(first.sigma));
  EXPECT_GT(first.sigma, 0.25f);
  EXPECT_LT(first.sunlit, 0.9f);
}

// Nothing of people is kept: what a passer-by covers for seconds never counts, and one who stands is forgotten.
TEST(GroundMemory, WhoPassesLeavesNoTrace) {
  const auto after = [](int covered_from, int covered_to) {
    Ground ground(0.2, 0.15);
    ground.see_day(0, 1.0, 6.0, 1.0);
    std::vector<GroundGuess> guesses;
    for (int second = 0; second < 180; ++second) {
      const bool covered = second >= covered_from && second < covered_to;
      guesses.push_back(ground.see(0, 6.0 + second / 3600.0, covered ? 0.05 : 1.0));
    }
    return std::pair(guesses, ground.memory().reflectance(0));
  };
  const auto [none, reflectance] = after(0, 0);
  for (int begin = 56; begin < 68; ++begin) {  // over the second in which the memory learns
    const auto [passed, same] = after(begin, begin + 2);
    for (std::size_t i = 0; i < none.size(); ++i) {
      ASSERT_NEAR(passed[i].sunlit, none[i].sunlit, 1e-4f) << begin << ", second " << i;
      ASSERT_NEAR(passed[i].sigma, none[i].sigma, 1e-3f);
    }
    ASSERT_EQ(same, reflectance);
  }
  // Longer, it is seen while it stands there; afterwards it is gone.
  const auto [stood, nearly] = after(50, 110);
  EXPECT_LT(stood[100].sunlit, 0.5f);
  for (std::size_t i = 114; i < none.size(); ++i) EXPECT_NEAR(stood[i].sunlit, none[i].sunlit, 0.004f) << i;
  EXPECT_NEAR(nearly, reflectance, 1e-6);
}

TEST(GroundMemory, FollowsGroundThatIsMadeAnew) {
  Ground gravel(0.45, 0.1, 0.02);
  for (int day = 0; day < 5; ++day) gravel.see_day(day, 1.0, 11.0, 1.0);
  EXPECT_GE(gravel.see(6, 4.0, 1.0).sunlit, 0.95f);
  EXPECT_LE(gravel.see(6, 8.0, 0.0).sunlit, 0.1f);
}

// Over a restart: of ground that it was told wrong, what it said before it says again at once.
TEST(GroundMemory, GoesOnFromWhatWasLearnt) {
  constexpr double kHour_s = 3600.0;
  Ground before(0.12, 0.3, 0.02), after(0.12, 0.3), old(0.12, 0.3), forgetful(0.12, 0.3);
  before.see_day(0, 1.0, 9.0, 1.0);
  ASSERT_TRUE(after.resume(before.memory().learnt(), 0.5 * kHour_s));
  EXPECT_NEAR(after.memory().reflectance(0) / before.memory().reflectance(0), 1.0, 0.06) << "a step";
  ASSERT_TRUE(old.resume(before.memory().learnt(), 15.0 * kDay_s));
  EXPECT_EQ(old.memory().reflectance(0), forgetful.memory().reflectance(0));
  for (const double sunlit : {1.0, 0.5, 0.0}) {
    const double hour = 9.5 + 0.1 * (1.0 - sunlit);
    const auto was = before.see(0, hour, sunlit), is = after.see(0, hour, sunlit),
               none = forgetful.see(0, hour, sunlit);
    fmt::print("sun {:.1f}: {:.3f} +- {:.3f}, after a restart {:.3f} +- {:.3f}, without what was learnt {:.3f}\n",
               sunlit, double(was.sunlit), double(was.sigma), double(is.sunlit), double(is.sigma), double(none.sunlit));
    EXPECT_NEAR(is.sunlit, was.sunlit, 0.03f);
    EXPECT_NEAR(is.sigma, was.sigma, 0.03f);
  }
}

TEST(GroundMemory, TakesNothingThatItHasNotWritten) {
  Ground ground(0.2, 0.15), other(0.2, 0.15);
  ground.see_day(0, 1.0, 6.0, 1.0);
  const auto learnt = ground.memory().learnt();
  const auto expect_refused = [&](std::vector<std::uint8_t> bytes, const char* why) {
    EXPECT_FALSE(other.resume(bytes, 0.0)) << why;
    EXPECT_EQ(other.memory().learnt(), Ground(0.2, 0.15).memory().learnt()) << why << ": nothing changes";
  };
  expect_refused({}, "nothing");
  expect_refused({learnt.begin(), learnt.end() - 1}, "the end is missing");
  auto two = learnt;
  two.insert(two.end(), learnt.begin(), learnt.end());
  expect_refused(two, "of two places");
  expect_refused(std::vector<std::uint8_t>(learnt.size(), 0), "no reflectance is possible");
  EXPECT_TRUE(other.resume(learnt, 0.0));
}

}  // namespace
}  // namespace kasumi
