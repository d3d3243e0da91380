// The first picture of a start: with the layer of the start before, or with one that is drawn soon, and replaced soon.
#include <algorithm>

#include <fmt/format.h>

#include "base/clock.hpp"
#include "tests/pipeline/show/scene/compositors.hpp"

namespace kasumi {
namespace {

// Each look takes as long as a piece of a layer on a slow machine.
class PieceClock final : public Clock {
 public:
  explicit PieceClock(Duration piece) : piece_(piece) {}
  Instant now() const override { return now_ += piece_; }
  Utc utc() const override { return {}; }
  void sleep_until(Instant instant) override { now_ = std::max(now_, instant); }
  void interrupt() override {}

 private:
  Duration piece_;
  mutable Instant now_{};
};

class LayersOfBefore : public Compositors {
 protected:
  void SetUp() override {
    Compositors::SetUp();
    if (IsSkipped()) return;
    if (!context_->info().software) GTEST_SKIP() << "a GPU draws a layer in less time than a disk takes";
    installation_.object.ground_light = false;  // else the layer changes with what is learnt of the ground
    frame_ = copied(lent(buffer_, returned_));
  }
  Compositor start(std::optional<LayerOfBefore> before = std::nullopt) {
    Compositor live = make({.mixing = Mixing::automatic});
    live.go_live(still_);
    if (before) live.layer().offer(std::move(*before));
    return live;
  }
  // From noon, to the west.
  void move_sun(double degrees) {
    const double angle = from_degrees(degrees).value;
    report_.sun.direction = SunDirection{-std::sin(angle), -0.6 * std::cos(angle), 0.8 * std::cos(angle)};
  }
  // Answers what is asked for, until the layer is as it will stay.
  void settle(Compositor& live) {
    const auto layers = live.layer().drawn();
    const auto question = live.layer().take_question();
    ASSERT_TRUE(question);
    live.adopt(answer(*question));
    drawn(live, frame_);
    ASSERT_EQ(live.layer().drawn(), layers + 1) << "by a clock that stands still, in one slice";
  }
  // As the appliance keeps it, and its picture.
  LayerOfBefore kept(Image<Rgb8>& picture) {
    Compositor before = start();
    drawn(before, frame_);
    EXPECT_FALSE(before.layer_to_keep()) << "its shadow is coarse";
    settle(before);
    picture = drawn(before, frame_);
    auto layer = before.layer_to_keep();
    EXPECT_TRUE(layer);
    return layer ? std::move(*layer) : LayerOfBefore{};
  }
  // Whether the picture is that of a start without an earlier one.
  void expect_drawn(const LayerOfBefore& before) {
    Compositor with = start(before), without = start();
    EXPECT_EQ(with.has_layer_for(report_), false);
    EXPECT_EQ(drawn(with, frame_).elements(), drawn(without, frame_).elements());
  }

  const Buffer buffer_{PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1};
  bool returned_ = false;
  Frame frame_;
  ManualClock still_{{}};
};

TEST_F(LayersOfBefore, AreShownToTheBitAndReplaced) {
  Image<Rgb8> expected;
  const auto before = kept(expected);
  Compositor live = start(before), at_once = make({.mixing = Mixing::automatic});
  EXPECT_TRUE(live.has_layer_for(report_));
  EXPECT_EQ(drawn(live, frame_).elements(), expected.elements());
  EXPECT_EQ(live.layer().drawn(), 1u);
  EXPECT_FALSE(live.layer_to_keep()) << "it would grow old, kept again and again";
  drawn(at_once, frame_);  // both measure the horizon under this sun
  move_sun(0.5);
  drawn(live, frame_);
  EXPECT_EQ(live.layer().drawn(), 1u);
  settle(live);
  settle(live);  // that was of the sun of the first picture
  EXPECT_EQ(drawn(live, frame_).elements(), drawn(at_once, frame_).elements());
  EXPECT_TRUE(live.layer_to_keep());
}

// As far off as one may be: a degree of the sun, three percent of haze.
TEST_F(LayersOfBefore, AreLessThanAStepOffByTheMean) {
  Image<Rgb8> expected;
  const auto before = kept(expected);
  const auto camera = [&] {
    Compositor alone = start();
    auto picture = decode(frame_, YuvEncoding::bt601_full);
    return picture_of([&](const DrawTarget& target) { return alone.draw_without_object(*picture, target); });
  }();
  for (const double degrees : {-0.99, 0.99}) {
    move_sun(degrees);
    Compositor live = start(before), now = make({.mixing = Mixing::automatic});
    ASSERT_TRUE(live.has_layer_for(report_));
    const auto shown = drawn(live, frame_), right = drawn(now, frame_);
    double sum = 0.0;
    int pixels = 0, others = 0, most = 0;
    for (std::size_t i = 0; i < shown.elements().size(); ++i) {
      if (right.elements()[i] == camera.elements()[i] && shown.elements()[i] == camera.elements()[i]) continue;
      const glm::ivec3 off = glm::abs(glm::ivec3(shown.elements()[i]) - glm::ivec3(right.elements()[i]));
      const int worst = std::max({off.r, off.g, off.b});
      sum += worst, ++pixels, others += worst > 2, most = std::max(most, worst);
    }
    ASSERT_GT(pixels, 1000);
    fmt::print("a sun {} degrees on: mean {:.2f} of 255, {:.1f} % of the object's pixels by more than 2, {} at most\n",
               degrees, sum / pixels, 100.0 * others / pixels, most);
    EXPECT_LE(sum / pixels, 1.0);
    EXPECT_LE(others, pixels / 12) << "shadows' edges";
  }
}

TEST_F(LayersOfBefore, Row56AreDrawnAnewUnderAnotherLight) {
  Image<Rgb8> expected;
  const auto before = kept(expected);
  auto strange = before;
  strange.turbidity *= 1.1;
  expect_drawn(strange);
  strange = before, strange.near_ground *= 1.1;
  expect_drawn(strange);
  strange = before, strange.past_hills -= 0.2;
  expect_drawn(strange);
  move_sun(1.01);
  expect_drawn(before);
}

TEST_F(LayersOfBefore, Row56ThatDoNotFitAreRefused) {
  Image<Rgb8> expected;
  const auto before = kept(expected);
  const auto expect_refused = [&](const LayerOfBefore& strange) {
    Compositor with = start(strange), without = start();
    EXPECT_EQ(drawn(with, frame_).elements(), drawn(without, frame_).elements());
  };
  auto strange = before;
  strange.layer.halves.elements()[7].y = 0x7E00;  // not a number
  expect_refused(strange);
  strange = before, strange.layer.halves = Image<glm::u16vec4>(3, 3);
  expect_refused(strange);
  strange = before, ++strange.layer.box.left;
  expect_refused(strange);
  strange = before, strange.layer.detail.point_spread_px = 1.0;
  expect_refused(strange);
  strange = before, strange.layer.detail.chroma_columns = 7;
  expect_refused(strange);
}

// Whatever the camera saw.
TEST_F(LayersOfBefore, HaveNoPixelOfTheCameras) {
  Image<Rgb8> first, second;
  const auto one = kept(first);
  Buffer other(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  other.fill(190);
  frame_ = copied(lent(other, returned_));
  const auto two = kept(second);
  EXPECT_NE(first.elements(), second.elements());
  EXPECT_EQ(one.layer.halves.elements(), two.layer.halves.elements());
}

// A layer of .7 s or more of a slow machine's work, however rare the pictures are.
TEST_F(LayersOfBefore, AreReplacedWithinFiveSecondsAtOneTwoAndThirtyPicturesASecond) {
  Image<Rgb8> expected;
  const auto before = kept(expected);
  for (const bool coarse : {false, true})
    for (const auto apart :
         {std::chrono::milliseconds(33), std::chrono::milliseconds(500), std::chrono::milliseconds(1000)}) {
      SCOPED_TRACE(
          fmt::format("{}, pictures {} ms apart", coarse ? "a coarse shadow" : "a layer of before", apart.count()));
      PieceClock clock(std::chrono::milliseconds(50));
      Compositor live = coarse ? start() : start(before);
      live.go_live(clock);
      Frame frame = frame_;
      Instant at{};
      drawn(live, frame);
      int pictures = 0;
      for (; live.layer().drawn() == 1 && pictures < 1000; ++pictures) {
        if (const auto question = live.layer().take_question()) live.adopt(answer(*question));
        frame.metadata.captured_at += apart;
        at += apart;
        drawn(live, frame);
      }
      const double took_s = std::chrono::duration<double>(pictures * apart).count();
      fmt::print("{} ms between pictures: replaced after {:.2f} s\n", apart.count(), took_s);
      EXPECT_LE(took_s, 5.0);
      EXPECT_TRUE(live.layer_to_keep());
    }
}

}  // namespace
}  // namespace kasumi
