// The picture of the compositor: with the wipe, of another size, without the sun, after a lost context.
#include <cmath>
#include <ctime>
#include <optional>

#include <fmt/format.h>

#include "base/files.hpp"
#include "tests/pipeline/show/scene/compositors.hpp"

namespace kasumi {
namespace {

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

TEST_F(Compositors, ShowTheCameraAloneWhileTheSunIsUnknown) {
  const Buffer buffer(PixelLayout::nv12, installation_.scene.yuv_encoding, kWidth, kHeight, 0, 1);
  bool returned = false;
  const auto frame = lent(buffer, returned);
  const auto picture = must(decode(frame, installation_.scene.yuv_encoding));
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
  context_ = std::move(*must(open_headless_context()));
  auto made = must(Compositor::create(*context_, installation_, model_, air));
  const auto after = drawn(*made, frame);
  const double wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const double cpu_s = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
  std::filesystem::rename(away, installation_.object.model);

  EXPECT_EQ(before.elements(), after.elements());
  EXPECT_LE(cpu_s, 2.0) << "seconds; time taken by other programs is not counted";
  fmt::print("row 17, GL context lost: the same picture after {:.2f} s ({:.2f} s of this program's own time)\n", wall_s,
             cpu_s);
}

}  // namespace
}  // namespace kasumi
