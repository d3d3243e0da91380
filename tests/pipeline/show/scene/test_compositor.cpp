// The scene camera's frames on the GPU: copied or imported, shown again, and restored after a lost context.
#include <chrono>
#include <cmath>
#include <ctime>
#include <optional>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/clock.hpp"
#include "base/files.hpp"
#include "capture/codec/encode.hpp"
#include "capture/frame.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/show/scene/compositor.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "tests/gles/picture/lent_buffers.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

constexpr int kWidth = 480, kHeight = 270;

#define ASSERT_OK(result)                                                                       \
  do {                                                                                          \
    auto&& kasumi_result = (result);                                                            \
    ASSERT_TRUE(kasumi_result.has_value()) << #result << ": " << kasumi_result.error().message; \
  } while (false)

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

class Compositors : public testing::Test {
 protected:
  static void SetUpTestSuite() { folder_ = new std::filesystem::path(recorded(small("clear-noon", 1), "compositor")); }
  static void TearDownTestSuite() { delete folder_; }

  void SetUp() override {
    auto context = open_headless_context();
    if (!context) GTEST_SKIP() << context.error().message;
    context_ = std::move(*context);
    auto fixture = read_fixture(*folder_);
    ASSERT_OK(fixture);
    installation_ = fixture->installation;
    auto model = read_gltf(installation_.object.model);
    ASSERT_OK(model);
    model_ = std::move(*model);
    report_.sun = {SunSource::ephemeris, SunDirection{0.0, -0.6, 0.8}, std::nullopt, false, {}};
    report_.estimate.sky = SkyCondition::clear;
  }

  Compositor make(const RendererOptions& options = {}) {
    auto made = Compositor::create(*context_, installation_, model_, SceneAir(installation_, {}), options);
    EXPECT_TRUE(made.has_value()) << (made ? "" : made.error().message);
    return std::move(*made);
  }
  RendererOptions with_test_images() {
    RendererOptions options;
    options.import_on_software = true;
    options.image_device = [this](const GlInfo&) -> Result<std::unique_ptr<ImageDevice>> {
      return std::make_unique<TestImages>(calls_);
    };
    return options;
  }

  // A frame in a driver's buffer; `returned` becomes true when the driver gets it back.
  static Frame lent(const Buffer& buffer, bool& returned) {
    returned = false;
    Frame frame;
    frame.metadata.format = four_cc("NV12");
    frame.metadata.width = kWidth;
    frame.metadata.height = kHeight;
    frame.metadata.stride = buffer.picture.planes[0].stride;
    frame.metadata.bytes_used = static_cast<std::uint32_t>(buffer.bytes());
    frame.payload.bytes = {buffer.view.planes[0].data, buffer.bytes()};
    frame.payload.dma_buf = DmaBuf{buffer.fd(), 0, buffer.picture.buffer};
    frame.payload.holder = std::shared_ptr<const void>(&buffer, [&returned](const void*) { returned = true; });
    return frame;
  }
  static Frame copied(Frame frame) {
    frame.payload = payload_of({frame.payload.bytes.begin(), frame.payload.bytes.end()});
    return frame;
  }

  template <class Draw>
  Image<Rgb8> picture_of(Draw draw) {
    auto target = Offscreen::create(context_->info(), kWidth, kHeight);
    EXPECT_TRUE(target.has_value());
    const auto drawn = draw(target->target());
    EXPECT_TRUE(drawn.has_value()) << (drawn ? "" : drawn.error().message);
    return target->read().value();
  }
  Image<Rgb8> drawn(Compositor& compositor, const Frame& frame) {
    return picture_of([&](const DrawTarget& target) { return compositor.draw(frame, report_, target); });
  }
  Image<Rgb8> drawn_again(Compositor& compositor) {
    return picture_of([&](const DrawTarget& target) { return compositor.draw_again(target); });
  }

  static inline const std::filesystem::path* folder_ = nullptr;
  ImageCalls calls_;
  std::unique_ptr<GlContext> context_;
  Installation installation_;
  Model model_;
  SkyReport report_;
};

// What a visitor wipes: both sides are the very pictures that they are whole, and the building is to be seen on one.
TEST_F(Compositors, ShowTheBarePictureLeftOfTheWipeAndThePlainOneRightOfIt) {
  const Buffer buffer(PixelLayout::nv12, installation_.scene.yuv_encoding, kWidth, kHeight, 0, 1);
  bool returned = false;
  Compositor compositor = make();
  const Frame frame = copied(lent(buffer, returned));
  const auto plain = drawn(compositor, frame);
  compositor.set_bare(1.0);
  const auto bare = drawn_again(compositor);
  EXPECT_NE(plain.elements(), bare.elements()) << "there is no building";
  EXPECT_EQ(bare.elements(), picture_of([&](const DrawTarget& target) {
                               return make().draw_without_object(
                                   decode(frame, installation_.scene.yuv_encoding).value(), target);
                             }).elements());
  for (const double share : {0.25, 0.5, 0.75}) {
    compositor.set_bare(share);
    const auto wiped = drawn_again(compositor);
    const int edge = static_cast<int>(std::lround(share * kWidth));
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        ASSERT_EQ(wiped.at(x, y), (x < edge ? bare : plain).at(x, y)) << x << ", " << y << " at " << share;
      }
  }
  compositor.set_bare(0.0);
  EXPECT_EQ(drawn_again(compositor).elements(), plain.elements());
}

TEST_F(Compositors, ReadALentFrameInPlaceAndDrawTheSameBits) {
  const Buffer buffer(PixelLayout::nv12, installation_.scene.yuv_encoding, kWidth, kHeight, 0, 1);
  bool returned = false;
  Compositor importing = make(with_test_images()), copying = make();
  Frame frame = lent(buffer, returned);
  const auto in_place = drawn(importing, frame), copy = drawn(copying, copied(frame));
  EXPECT_EQ(in_place.elements(), copy.elements());
  EXPECT_EQ(importing.frames().imported, 1u);
  EXPECT_EQ(importing.frames().uploaded, 0u) << "copies";
  EXPECT_EQ(copying.frames().uploaded, 1u);
  EXPECT_GE(importing.layer().drawn(), 1u);
}

TEST_F(Compositors, KeepALentBufferUntilTheNextFrame) {
  const Buffer first(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  const Buffer second(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 2);
  bool first_returned = false, second_returned = false;
  Compositor compositor = make(with_test_images());
  drawn(compositor, lent(first, first_returned));
  EXPECT_FALSE(first_returned);
  drawn(compositor, lent(second, second_returned));
  EXPECT_TRUE(first_returned);
  EXPECT_FALSE(second_returned);
}

TEST_F(Compositors, ShowAPictureAgainWithoutKeepingTheDriversBuffer) {
  Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  bool returned = false;
  Compositor compositor = make(with_test_images());
  const auto before = drawn(compositor, lent(buffer, returned));
  EXPECT_EQ(drawn_again(compositor).elements(), before.elements());
  EXPECT_TRUE(returned) << "an unplugged camera comes back only when its buffers are released";
  buffer.fill(17);  // the driver may reuse it now
  EXPECT_EQ(drawn_again(compositor).elements(), before.elements());
  EXPECT_EQ(compositor.frames().uploaded, 1u) << "one copy, however often it is shown";
}

// A driver frees no memory that the GPU has imported: a camera that is gone for hours, or one that needs its memory
// again, must get it back at once.
TEST_F(Compositors, GiveTheBuffersOfACameraBackThatIsGone) {
  Buffer first(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  Buffer second(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 2);
  bool first_returned = false, second_returned = false;
  Compositor compositor = make(with_test_images());
  drawn(compositor, lent(first, first_returned));
  const auto before = drawn(compositor, lent(second, second_returned));
  EXPECT_EQ(calls_.destroyed, 0);
  EXPECT_TRUE(compositor.drop_camera_buffers());
  EXPECT_EQ(static_cast<std::size_t>(calls_.destroyed), calls_.made.size()) << "no image holds the driver's memory";
  EXPECT_TRUE(second_returned);
  second.fill(17);
  EXPECT_EQ(drawn_again(compositor).elements(), before.elements()) << "the last picture stays";
  EXPECT_TRUE(compositor.drop_camera_buffers()) << "nothing is left to give back";
  const auto after = drawn(compositor, lent(first, first_returned));
  EXPECT_NE(after.elements(), before.elements()) << "the camera is back";
  EXPECT_EQ(compositor.frames().imported, 3u);
}

TEST_F(Compositors, KeepTheLastPictureWhenOneOfAnotherSizeComes) {
  const Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  const Buffer small_buffer(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth / 2, kHeight / 2, 0, 2);
  bool returned = false, small_returned = false;
  Frame other = lent(small_buffer, small_returned);
  other.metadata.width = kWidth / 2;
  other.metadata.height = kHeight / 2;
  for (const bool importing : {false, true}) {
    Compositor compositor = importing ? make(with_test_images()) : make();
    const auto before = drawn(compositor, lent(buffer, returned));
    auto target = Offscreen::create(context_->info(), kWidth, kHeight);
    const auto refused = compositor.draw(other, report_, target->target());
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, FaultKind::bad_input);
    EXPECT_EQ(drawn_again(compositor).elements(), before.elements());
  }
}

TEST_F(Compositors, CopyWhatTheGpuCannotImport) {
  calls_.refused = {"*"};
  const Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  bool returned = false;
  Compositor compositor = make(with_test_images()), copying = make();
  const Frame frame = lent(buffer, returned);
  EXPECT_EQ(drawn(compositor, frame).elements(), drawn(copying, copied(frame)).elements());
  EXPECT_EQ(compositor.frames().uploaded, 1u);
  EXPECT_THAT(compositor.notes(), testing::Contains(testing::HasSubstr("copied")));
}

TEST_F(Compositors, ShowTheCameraAloneWhileTheSunIsUnknown) {
  const Buffer buffer(PixelLayout::nv12, installation_.scene.yuv_encoding, kWidth, kHeight, 0, 1);
  bool returned = false;
  const auto frame = lent(buffer, returned);
  const auto picture = decode(frame, installation_.scene.yuv_encoding);
  ASSERT_OK(picture);
  Compositor compositor = make();
  EXPECT_FALSE(compositor.draw_again({}).has_value()) << "nothing has been drawn yet";
  const auto alone =
      picture_of([&](const DrawTarget& target) { return compositor.draw_without_object(*picture, target); });
  const auto expected = to_rgb(picture->view());
  int worst = 0;
  for (std::size_t i = 0; i < alone.elements().size(); ++i)
    for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(alone.elements()[i][c] - expected.elements()[i][c]));
  EXPECT_LE(worst, 1) << "steps of 255";
  EXPECT_EQ(compositor.layer().drawn(), 0u);
  EXPECT_EQ(drawn_again(compositor).elements(), alone.elements());
}

TEST_F(Compositors, Row17AreRestoredFromMemoryWhenTheContextIsLost) {
  const Buffer buffer(PixelLayout::nv12, YuvEncoding::bt601_full, kWidth, kHeight, 0, 1);
  bool returned = false;
  const Frame frame = lent(buffer, returned);
  std::optional<Compositor> compositor = make();
  drawn(*compositor, frame);
  const auto before = drawn(*compositor, frame);

  // The GPU was reset: every GL object is gone, and since the content files were moved away nothing can be reloaded.
  const auto away = installation_.object.model.string() + ".away";
  std::filesystem::rename(installation_.object.model, away);
  const auto cpu = std::clock();
  const auto begin = std::chrono::steady_clock::now();
  const SceneAir air = compositor->air();
  compositor.reset();
  context_.reset();
  auto context = open_headless_context();
  ASSERT_OK(context);
  context_ = std::move(*context);
  auto made = Compositor::create(*context_, installation_, model_, air);
  ASSERT_OK(made);
  const auto after = drawn(*made, frame);
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const double cpu_s = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  std::filesystem::rename(away, installation_.object.model);

  EXPECT_EQ(before.elements(), after.elements());
  EXPECT_LE(cpu_s, 2.0) << "seconds; time taken by other programs is not counted";
  fmt::print("row 17, GL context lost: the same picture after {:.2f} s ({:.2f} s of this program's own time)\n", wall_s,
             cpu_s);
}

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
    const auto layer = live.layer().take_question();
    if (!layer) return false;
    live.adopt(answer(*layer));
    const auto layers = live.layer().drawn();
    for (int i = 0; i < 500 && live.layer().drawn() == layers; ++i) drawn(live, frame);
    return true;
  }
  // Until all is known of the frame's ground that can be.
  void settle(Compositor& live, Frame& frame) {
    if (!GetParam()) return;
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
  EXPECT_FALSE(live.layer().take_question());
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

// Whoever was asked may have died of the question.
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
  expect_same(drawn(live, after), GetParam() ? drawn(at_once, after) : expected);
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
    auto fixture = read_fixture(*near_);
    ASSERT_OK(fixture);
    installation_ = fixture->installation;
    installation_.object.ground_light = true;
    auto model = read_gltf(installation_.object.model);
    ASSERT_OK(model);
    model_ = std::move(*model);
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
  live.go_live(clock);
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

// A land of stripes and spots; each picture has noise of its own. Somebody in red stands at `left`, `top`, where asked.
Frame picture_at(int second, std::optional<glm::ivec2> left_top = std::nullopt) {
  Image<Rgb8> picture(kWidth, kHeight);
  std::uint32_t noise = static_cast<std::uint32_t>(second) + 1;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      noise = noise * 1664525U + 1013904223U;
      const int land = 90 + 40 * (x / 9 % 2) + 20 * (y / 7 % 2) + static_cast<int>(noise >> 30U);
      picture.at(x, y) = Rgb8(land, land + 10, land - 20);
    }
  if (left_top)
    for (int y = 0; y < 40; ++y)
      for (int x = 0; x < 16; ++x) picture.at(left_top->x + x, left_top->y + y) = {200, 30, 30};
  Frame frame = encode_frame(picture, four_cc("RGB3")).value();
  frame.metadata.captured_at = Instant{} + std::chrono::seconds(second);
  return frame;
}

TEST_F(Compositors, KeepWhoPassesInFrontWhereThatIsAskedFor) {
  constexpr int kLearnt_s = 140;
  Compositor over = make();
  installation_.people_in_front = true;
  Compositor behind = make();
  for (int second = 0; second < kLearnt_s; ++second) {
    drawn(behind, picture_at(second));
    if (second == 10) {
      ASSERT_EQ(behind.around().passers()->state, PassersState::learning);
    }
  }
  ASSERT_EQ(behind.around().passers()->state, PassersState::watching);
  drawn(behind, picture_at(kLearnt_s));
  EXPECT_EQ(behind.look()->passers, 0U);

  const PixelBox box = behind.object_box();
  const glm::ivec2 at{(box.left + box.right) / 2 - 8, (box.top + box.bottom) / 2 - 20};
  const Frame somebody = picture_at(kLearnt_s + 1, at);
  const auto painted = drawn(over, somebody), kept = drawn(behind, somebody);
  EXPECT_EQ(over.around().passers(), nullptr);
  EXPECT_NE(behind.look()->passers, 0U);
  const Image<Rgb8> camera = to_rgb(decode(somebody, YuvEncoding::bt601_full)->view());
  int painted_over = 0, lost = 0;
  for (int y = 2; y < 38; ++y)
    for (int x = 2; x < 14; ++x) {
      painted_over += painted.at(at.x + x, at.y + y) != camera.at(at.x + x, at.y + y);
      lost += kept.at(at.x + x, at.y + y) != camera.at(at.x + x, at.y + y);
    }
  EXPECT_GT(painted_over, 100);  // the building covers him there
  EXPECT_EQ(lost, 0);
}

}  // namespace
}  // namespace kasumi
