// A live picture: layers drawn in slices, and what is measured and learnt beside it.
#include <fmt/format.h>

#include "base/clock.hpp"
#include "base/files.hpp"
#include "capture/codec/encode.hpp"
#include "tests/pipeline/show/scene/compositors.hpp"

namespace kasumi {
namespace {

// Goes on by three milliseconds with each look: two looks are more than a slice.
class GoingClock final : public Clock {
 public:
  Instant now() const override { return now_ += std::chrono::milliseconds(3); }
  Utc utc() const override { return {}; }
  void sleep_until(Instant) override {}
  void interrupt() override {}

 private:
  mutable Instant now_{};
};

// Once with the ground taken as lit, once with it looked at. A live picture does not wait for the first look at it, any
// more than for another measurement: until that is answered, within seconds of the start, the ground counts as lit.
class LiveCompositors : public Compositors, public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    Compositors::SetUp();
    installation_.object.ground_light = GetParam();
  }
  // A second later, with whatever is asked answered and drawn; true: there was a layer to draw.
  bool go_on(Compositor& live, Frame& frame) {
    frame.metadata.captured_at += std::chrono::seconds(1);
    drawn(live, frame);
    if (const auto horizon = live.around().take_question()) {
      if (horizon->ground) horizon->ground->watch->shade_foot(true);  // else in many answers
      live.adopt(answer(*horizon));
    }
    drawn(live, frame);
    return draw_layer(live, frame);
  }
  bool draw_layer(Compositor& live, const Frame& frame) {
    const auto layer = live.layer().take_question();
    if (!layer) return false;
    live.adopt(answer(*layer));
    const auto layers = live.layer().drawn();
    for (int i = 0; i < 500 && live.layer().drawn() == layers; ++i) drawn(live, frame);
    return true;
  }
  // Until the first layer's shadow is as fine as any, and all is known of the frame's ground that can be.
  void settle(Compositor& live, Frame& frame) {
    if (!GetParam()) {
      drawn(live, frame);
      draw_layer(live, frame);
      return;
    }
    for (int quiet = 0, i = 0; i < 100; ++i) {
      quiet = go_on(live, frame) ? 0 : quiet + 1;
      if (live.around().ground().sunlight && live.around().ground().sky && quiet > kLately) return;
    }
    ADD_FAILURE() << "it asks on and on";
  }
  // To the bit; what was learnt of the ground meanwhile may differ by what is not redrawn for.
  static void expect_same(const Image<Rgb8>& a, const Image<Rgb8>& b) {
    if (!GetParam()) {
      EXPECT_EQ(a.elements(), b.elements());
      return;
    }
    expect_alike(a, b);
  }
  static void expect_alike(const Image<Rgb8>& a, const Image<Rgb8>& b) {
    const auto [most, others] = difference(a, b);
    EXPECT_LE(others, kWidth * kHeight / 1000) << "pixels by more than 2 of 255, " << most << " at most";
  }
  // Of 255, and how many pixels differ by more than 2.
  static std::pair<int, int> difference(const Image<Rgb8>& a, const Image<Rgb8>& b) {
    int most = 0, others = 0;
    for (std::size_t i = 0; i < a.elements().size(); ++i) {
      const glm::ivec3 off = glm::abs(glm::ivec3(a.elements()[i]) - glm::ivec3(b.elements()[i]));
      const int worst = std::max({off.r, off.g, off.b});
      most = std::max(most, worst);
      others += worst > 2;
    }
    return {most, others};
  }
  static constexpr int kLately = 6;  // looks at the ground that count
};
INSTANTIATE_TEST_SUITE_P(GroundTakenAsLit, LiveCompositors, testing::Values(false));
INSTANTIATE_TEST_SUITE_P(GroundLookedAt, LiveCompositors, testing::Values(true));

// A kiosk's picture never waits for a whole layer, nor for what it is drawn under.
TEST_P(LiveCompositors, RedrawALayerOverSeveralPictures) {
  const Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  bool returned = false;
  Frame frame = copied(lent(buffer, returned));
  GoingClock clock;
  Compositor live = make(), at_once = make();
  live.go_live(clock);
  for (auto* compositor : {&live, &at_once}) drawn(*compositor, frame);
  EXPECT_EQ(live.layer().drawn(), 1u) << "the first, without which there is no building";
  settle(live, frame);
  const auto layers = live.layer().drawn();
  report_.sun.direction = SunDirection{0.36, -0.48, 0.8};
  const auto before = drawn(live, frame);
  const auto question = live.layer().take_question();
  ASSERT_TRUE(question);
  for (int i = 0; i < 3; ++i) drawn(live, frame);
  EXPECT_FALSE(live.layer().take_question()) << "one at a time";
  live.adopt(answer(*question));
  EXPECT_EQ(drawn(live, frame).elements(), before.elements());
  EXPECT_EQ(live.layer().drawn(), layers);
  int pictures = 1;
  while (live.layer().drawn() == layers && pictures < 500) drawn(live, frame), ++pictures;
  EXPECT_GT(pictures, 10) << "the shadow's maps take two slices or more";
  EXPECT_EQ(live.layer().drawn(), layers + 1);
  settle(live, frame);
  expect_same(drawn(live, frame), drawn(at_once, frame));
  EXPECT_FALSE(live.layer().take_question());
}

// Where GL is software the first picture does not wait for fine shadows.
TEST_P(LiveCompositors, BeginWithACoarseShadowAndReplaceIt) {
  const Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  bool returned = false;
  Frame frame = copied(lent(buffer, returned));
  ManualClock clock({});
  Compositor live = make(), at_once = make();
  live.go_live(clock);
  const auto first = drawn(live, frame), fine = drawn(at_once, frame);
  const bool coarse = context_->info().software;
  EXPECT_EQ(first.elements() != fine.elements(), coarse);
  drawn(live, frame);
  const auto question = live.layer().take_question();
  ASSERT_EQ(question.has_value(), coarse);
  if (!coarse) return;
  live.adopt(answer(*question));
  drawn(live, frame);
  EXPECT_EQ(live.layer().drawn(), 2u);
  settle(live, frame);
  expect_same(drawn(live, frame), drawn(at_once, frame));
  drawn(live, frame);
  EXPECT_FALSE(live.layer().take_question());
}

TEST_P(LiveCompositors, ChangeTheirDetailTheSameWay) {
  const Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  bool returned = false;
  installation_.scene_quality.point_spread_px = 1.0;
  installation_.scene_quality.shared_chroma = true;
  Frame with_shared_colour = copied(lent(buffer, returned));
  Frame frame = with_shared_colour;
  frame.metadata.format = four_cc("RGB3");
  frame.metadata.stride = 3 * kWidth;
  frame.payload = payload_of(std::vector<std::uint8_t>(std::size_t{3} * kWidth * kHeight, 90));
  frame.metadata.bytes_used = static_cast<std::uint32_t>(frame.payload.bytes.size());
  ManualClock clock({});
  Compositor live = make(), at_once = make();
  live.go_live(clock);
  for (auto* compositor : {&live, &at_once}) drawn(*compositor, with_shared_colour);
  settle(live, with_shared_colour);
  frame.metadata.captured_at = with_shared_colour.metadata.captured_at;
  const auto layers = live.layer().drawn();
  drawn(live, frame);
  EXPECT_EQ(live.layer().drawn(), layers);
  const auto question = live.layer().take_question();
  ASSERT_TRUE(question);
  live.adopt(answer(*question));
  drawn(live, frame);
  EXPECT_EQ(live.layer().drawn(), layers + 1) << "by a clock that stands still, in one slice";
  settle(live, frame);
  expect_same(drawn(live, frame), drawn(at_once, frame));
  EXPECT_EQ(live.object_box().left, at_once.object_box().left);
}

// A worker that has not answered is given up.
TEST_P(LiveCompositors, AskForALayerAgain) {
  const Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  bool returned = false;
  Frame frame = copied(lent(buffer, returned));
  ManualClock clock({});
  Compositor live = make();
  live.go_live(clock);
  drawn(live, frame);
  report_.sun.direction = SunDirection{0.36, -0.48, 0.8};
  drawn(live, frame);
  const auto lost = live.layer().take_question();
  ASSERT_TRUE(lost);
  frame.metadata.captured_at += std::chrono::seconds(10);
  drawn(live, frame);
  EXPECT_FALSE(live.layer().take_question());
  frame.metadata.captured_at += std::chrono::seconds(11);
  drawn(live, frame);
  const auto again = live.layer().take_question();
  ASSERT_TRUE(again);
  live.adopt(answer(*lost));
  drawn(live, frame);
  EXPECT_EQ(live.layer().drawn(), 1u) << "an answer to an earlier question";
  live.adopt(answer(*again));
  drawn(live, frame);
  EXPECT_EQ(live.layer().drawn(), 2u);
}

TEST_P(LiveCompositors, LetSomebodyElseMeasureTheHorizon) {
  const Buffer first(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  Buffer second(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  second.fill(90);
  bool returned = false, second_returned = false;
  Compositor live = make(with_test_images()), at_once = make();
  ManualClock clock({});
  live.go_live(clock);
  Frame frame = lent(first, returned), later = lent(second, second_returned);
  later.metadata.captured_at += std::chrono::seconds(2);
  const auto later_copy = copied(later);
  for (auto* compositor : {&live, &at_once}) drawn(*compositor, copied(frame));
  EXPECT_FALSE(live.around().take_question()) << "the first picture needs its own";

  const auto waiting = drawn(live, later);
  const auto question = live.around().take_question();
  ASSERT_TRUE(question);
  EXPECT_FALSE(live.around().take_question());
  const auto expected = drawn(at_once, later_copy);
  EXPECT_NE(waiting.elements(), expected.elements()) << "nothing was measured yet";
  later = {};
  drawn(live, copied(frame));
  EXPECT_TRUE(second_returned) << "the question has a copy";
  second.fill(200);
  live.adopt(answer(*question));
  Frame after = later_copy;
  settle(live, after);  // the answer holds a look at the ground, by which the layer is drawn again
  // The layer with the finer shadow was drawn after the first horizon had been measured, the other one before.
  expect_alike(drawn(live, after), GetParam() ? drawn(at_once, after) : expected);
}

TEST_P(LiveCompositors, LeaveWhatWasMeasuredForOthers) {
  const Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  bool returned = false;
  const Frame frame = copied(lent(buffer, returned));
  Compositor live = make(), other = make();
  ManualClock clock({});
  live.go_live(clock);
  const auto before = drawn(live, frame);
  HorizonAnswer strange{other.air().observer(), frame.metadata, live.air().horizon()};
  ASSERT_FALSE(strange.seen.columns.empty());
  for (auto& column : strange.seen.columns) column.light *= 3.0;
  live.adopt(strange);
  EXPECT_EQ(drawn(live, frame).elements(), before.elements());
}

class GroundOfCompositors : public LiveCompositors {
 protected:
  static void SetUpTestSuite() {
    LiveCompositors::SetUpTestSuite();
    auto recipe = small("clear-noon", 1);
    recipe.outlook = fixtures::outlook_on(250.0);
    near_ = new std::filesystem::path(recorded(recipe, "compositor-near"));
  }
  static void TearDownTestSuite() {
    delete near_;
    LiveCompositors::TearDownTestSuite();
  }
  void SetUp() override {
    LiveCompositors::SetUp();
    if (IsSkipped()) return;
    play(*near_);
    installation_.object.ground_light = true;
  }

  // The recording's picture; where `shade` is not 1, the land below the building's middle is darker by so much.
  Frame recorded_frame(const Compositor& compositor, double shade) {
    const auto bytes = read_file(*near_ / "scene/frame-000000.rgb3").value();
    Image<Rgb8> picture(kWidth, kHeight);
    const PixelBox box = compositor.object_box();
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const auto* at = bytes.data() + 3 * (static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x));
        const double factor = y > (box.top + box.bottom) / 2 ? shade : 1.0;
        for (int c = 0; c < 3; ++c) picture.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(factor * at[c]));
      }
    return encode_frame(picture, four_cc("RGB3")).value();
  }

  static inline const std::filesystem::path* near_ = nullptr;
};
INSTANTIATE_TEST_SUITE_P(, GroundOfCompositors, testing::Values(true));

TEST_P(GroundOfCompositors, CountsAsLitUntilItIsLookedAt) {
  ManualClock clock({});
  Compositor live = make(), at_once = make();
  installation_.object.ground_light = false;
  Compositor lit = make();
  for (auto* compositor : {&live, &lit}) compositor->go_live(clock);
  Frame frame = recorded_frame(live, 0.5);
  const auto first = drawn(live, frame), as_lit = drawn(lit, frame), looked_at = drawn(at_once, frame);
  EXPECT_EQ(first.elements(), as_lit.elements()) << "waits for nothing";
  const auto [most, others] = difference(first, looked_at);
  fmt::print("before the first look {} pixels are off, by {} of 255 at most\n", others, most);
  EXPECT_GT(others, 200);
  settle(live, frame);
  expect_same(drawn(live, frame), drawn(at_once, frame));
}

// As the appliance does it: what the last one learnt is handed to the watch that the first question names. The model says
// that the ground is four times as pale as it is: who begins anew takes it to lie in the shade.
TEST_P(GroundOfCompositors, GivesTheSamePictureAfterARestart) {
  for (const ModelPart& part : model_.ground) {
    auto& colour = model_.materials[static_cast<std::size_t>(part.material)].base_colour;
    colour = glm::vec4(glm::min(4.0f * glm::vec3(colour), glm::vec3(1.0f)), colour.a);
  }
  ManualClock clock({});
  Compositor before = make();
  before.go_live(clock);
  Frame lit = recorded_frame(before, 1.0), shaded = recorded_frame(before, 0.5);
  drawn(before, lit);
  Instant now = lit.metadata.captured_at;
  for (int lesson = 0; lesson < 12; ++lesson) {
    Frame& frame = lesson % 2 == 0 ? lit : shaded;
    frame.metadata.captured_at = now += std::chrono::minutes(10);
    go_on(before, frame);
  }
  lit.metadata.captured_at = now += std::chrono::minutes(10);
  drawn(before, lit);
  const auto asked = before.around().take_question();
  ASSERT_TRUE(asked && asked->ground);
  const LearntGround learnt = asked->ground->watch->learnt();
  before.adopt(answer(*asked));
  settle(before, lit);
  const auto expected = drawn(before, lit);
  const auto started = [&](bool with_what_was_learnt) {
    Compositor live = make();
    live.go_live(clock);
    lit.metadata.captured_at = now;
    drawn(live, lit);
    lit.metadata.captured_at += std::chrono::seconds(2);
    drawn(live, lit);
    const auto question = live.around().take_question();
    EXPECT_TRUE(question && question->ground);
    if (with_what_was_learnt) {
      EXPECT_TRUE(question->ground->watch->resume(learnt, 2.0));
    }
    live.adopt(answer(*question));
    settle(live, lit);
    return drawn(live, lit);
  };
  expect_same(started(true), expected);
  const auto [most, others] = difference(started(false), expected);
  fmt::print("begun anew, {} pixels are off, by {} of 255 at most\n", others, most);
  EXPECT_GT(others, 200);
}

}  // namespace
}  // namespace kasumi
