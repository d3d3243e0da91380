// What a visitor's hand has chosen, under a clock that the test turns.
#include "pipeline/kiosk/visitor/visitor_hand.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "pipeline/site/visitor/building_view.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using Kind = HandEvent::Kind;

struct Standing {
  explicit Standing(const VisitorHand::Limits& limits = {3, 6, 0.05, 45s}) : hand(limits) {}
  void take(const HandEvent& event) { hand.take(event, now); }
  double bare_after(Duration time) {
    now += time;
    hand.step(now);
    return hand.choice().bare;
  }
  Instant now{};
  VisitorHand hand;
};

TEST(VisitorHand, AHeldButtonShowsTheBarePictureAndGlidesBack) {
  Standing at;
  at.take({Kind::down, HandKey::then_and_now});
  EXPECT_GT(at.bare_after(200ms), 0.0);
  EXPECT_DOUBLE_EQ(at.bare_after(300ms), 1.0);
  EXPECT_DOUBLE_EQ(at.bare_after(10s), 1.0);
  at.take({Kind::up, HandKey::then_and_now});
  EXPECT_NEAR(at.bare_after(750ms), 0.5, 1e-9);
  EXPECT_GT(at.bare_after(740ms), 0.0);
  EXPECT_DOUBLE_EQ(at.bare_after(10ms), 0.0) << "after 1.5 s";
  EXPECT_FALSE(at.hand.is_moving());
}

TEST(VisitorHand, AFingerWipesAndLetsGo) {
  Standing at;
  at.take({Kind::touch, {}, 0.3});
  EXPECT_DOUBLE_EQ(at.hand.choice().bare, 0.3);
  at.take({Kind::touch, {}, 0.8});
  EXPECT_DOUBLE_EQ(at.bare_after(5s), 0.8);
  at.take({Kind::touch_end});
  EXPECT_GT(at.bare_after(1490ms), 0.0);
  EXPECT_DOUBLE_EQ(at.bare_after(10ms), 0.0);
  EXPECT_EQ(at.hand.presses()[0], 1U) << "one gesture";
}

TEST(VisitorHand, AKnobIsLetGoWhenItRests) {
  Standing at;
  at.take({Kind::turn, {}, 8.0});
  EXPECT_NEAR(at.hand.choice().bare, 0.4, 1e-12);
  EXPECT_NEAR(at.bare_after(1900ms), 0.4, 1e-12);
  at.take({Kind::turn, {}, 1000.0});
  EXPECT_DOUBLE_EQ(at.bare_after(1900ms), 1.0);
  at.bare_after(100ms);
  EXPECT_DOUBLE_EQ(at.bare_after(1500ms), 0.0);
}

TEST(VisitorHand, ChoosesInTurn) {
  Standing at;
  for (const std::size_t era : {1U, 2U, 0U, 1U}) {
    at.take({Kind::down, HandKey::era});
    at.take({Kind::up, HandKey::era});
    EXPECT_EQ(at.hand.choice().era, era);
  }
  at.take({Kind::down, HandKey::language});
  EXPECT_EQ(at.hand.choice().language, 1U);
  EXPECT_EQ(at.hand.pressed(at.now), HandKey::language);
  at.bare_after(3s);
  EXPECT_EQ(at.hand.pressed(at.now), std::nullopt);
  at.take({Kind::down, HandKey::large_print});
  EXPECT_TRUE(at.hand.choice().large_print);
  at.take({Kind::down, HandKey::large_print});
  EXPECT_FALSE(at.hand.choice().large_print);
  EXPECT_EQ(at.hand.presses(), (std::array<std::uint64_t, kHandKeys>{0, 4, 1, 2, 0}));
}

TEST(VisitorHand, ReadsOneStoryAfterTheOther) {
  Standing at;
  at.take({Kind::down, HandKey::story});
  EXPECT_EQ(at.hand.choice().story, 0U) << "there is none";
  at.hand.offer_stories(2);
  for (const std::size_t story : {1U, 2U, 0U, 1U, 2U}) {
    at.take({Kind::down, HandKey::story});
    EXPECT_EQ(at.hand.choice().story, story);
  }
  at.hand.offer_stories(1);
  EXPECT_EQ(at.hand.choice().story, 0U) << "another era tells less";
}

TEST(VisitorHand, OneVisitorsChoiceNeverMeetsTheNext) {
  Standing at;
  at.hand.offer_stories(3);
  at.take({Kind::down, HandKey::story});
  at.take({Kind::down, HandKey::era});
  at.take({Kind::down, HandKey::language});
  at.take({Kind::down, HandKey::large_print});
  at.bare_after(44'999ms);
  EXPECT_FALSE(at.hand.is_idle());
  EXPECT_TRUE(at.hand.choice().large_print);
  at.bare_after(1ms);
  EXPECT_TRUE(at.hand.is_idle());
  EXPECT_EQ(at.hand.choice(), VisitorHand::Choice{});
}

TEST(VisitorHand, AButtonThatSticksIsLetGo) {
  Standing at;
  at.take({Kind::down, HandKey::then_and_now});
  EXPECT_DOUBLE_EQ(at.bare_after(44s), 1.0);
  at.bare_after(1s);
  EXPECT_DOUBLE_EQ(at.bare_after(1500ms), 0.0);
  at.take({Kind::up, HandKey::then_and_now});
  at.take({Kind::down, HandKey::then_and_now});
  EXPECT_DOUBLE_EQ(at.bare_after(1s), 1.0) << "and can be pressed again";
}

TEST(VisitorHand, ADeviceThatGoesLetsGo) {
  Standing at;
  at.take({Kind::touch, {}, 0.7});
  at.take({Kind::all_up});
  EXPECT_DOUBLE_EQ(at.bare_after(1500ms), 0.0);
}

TEST(VisitorHand, TenThousandRandomInputsLeaveItSane) {
  std::mt19937 random(7);
  Standing at;
  at.hand.offer_stories(4);
  const double values[] = {0.0,
                           1.0,
                           -1.0,
                           0.5,
                           1e300,
                           -1e300,
                           std::numeric_limits<double>::quiet_NaN(),
                           std::numeric_limits<double>::infinity()};
  for (int i = 0; i < 10'000; ++i) {
    if (random() % 100 == 0) at.bare_after(from_seconds(static_cast<double>(random() % 60)));
    at.bare_after(std::chrono::milliseconds(random() % 50));
    at.take({static_cast<Kind>(random() % 6), static_cast<HandKey>(random() % kHandKeys), values[random() % 8]});
    const auto& choice = at.hand.choice();
    ASSERT_TRUE(choice.bare >= 0.0 && choice.bare <= 1.0) << choice.bare << " after input " << i;
    ASSERT_LT(choice.era, 3U);
    ASSERT_LT(choice.language, 6U);
    ASSERT_LE(choice.story, 4U);
    ASSERT_LT(choice.view, kBuildingViews);
    if (i % 1000 != 999) continue;
    auto idle = at;  // nobody comes any more
    idle.bare_after(45s);
    idle.bare_after(1500ms);
    ASSERT_EQ(idle.hand.choice(), VisitorHand::Choice{}) << "after input " << i;
    ASSERT_TRUE(idle.hand.is_idle());
  }
}

}  // namespace
}  // namespace kasumi
