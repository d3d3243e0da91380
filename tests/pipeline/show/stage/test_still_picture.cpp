// The still picture and the sky behind it.
#include <cmath>

#include <gtest/gtest.h>

#include "base/files.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/show/stage/still_picture.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/heap_in_use.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

constexpr int kWidth = 320, kHeight = 180;

// A wall up to the horizon with open sky above: the lower half opaque and red, the upper transparent.
Image<Rgba8> wall() {
  Image<Rgba8> picture(kWidth, kHeight, Rgba8{255, 255, 255, 0});
  for (int y = kHeight / 2; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) picture.at(x, y) = Rgba8{180, 30, 20, 255};
  return picture;
}

Content content(std::optional<Image<Rgba8>> still) {
  Content made;
  Camera& scene = made.config.installation.scene;
  scene.width = kWidth;
  scene.height = kHeight;
  scene.lens = pinhole_lens({{300.0, 300.0}, {0.5 * (kWidth - 1), 0.5 * (kHeight - 1)}, {}});
  scene.to_world = camera_to_world(from_degrees(0.0), from_degrees(0.0), {0.0});
  made.config.installation.site.altitude_m = 500.0;
  if (still) made.still = std::make_shared<const Image<Rgba8>>(std::move(*still));
  return made;
}

SkyReport report(double sun_zenith_deg, SkyCondition sky = SkyCondition::clear, double turbidity = 2.1) {
  SkyReport made;
  made.sun.source = SunSource::ephemeris;
  made.sun.direction = direction_from(from_degrees(sun_zenith_deg), from_degrees(150.0));
  made.estimate.sky = sky;
  made.estimate.clear_fraction = sky == SkyCondition::overcast ? 0.0 : 1.0;
  made.air.emplace().air = Turbidity{turbidity};
  made.air->observers.emplace_back();
  return made;
}

class StillPictureTest : public testing::Test {
 protected:
  void SetUp() override {
    auto context = open_headless_context();
    if (!context) GTEST_SKIP() << context.error().message;
    context_ = std::move(*context);
  }
  Image<Rgb8> drawn(StillPicture& still, const SkyReport& sky, double opacity = 1.0) {
    auto target = Offscreen::create(context_->info(), kWidth, kHeight).value();
    clear_to(target.target(), glm::vec3(0.0f));
    EXPECT_TRUE(still.draw(target.target(), sky, opacity));
    return target.read().value();
  }
  Image<Rgb8> drawn(const Content& of, const SkyReport& sky) {
    auto still = StillPicture::create(*context_, of).value();
    return drawn(still, sky);
  }
  std::unique_ptr<GlContext> context_;
};

double luminance(const Rgb8& colour) {
  return 0.2126 * colour.r + 0.7152 * colour.g + 0.0722 * colour.b;
}

TEST_F(StillPictureTest, AnOpaqueOneIsShownUnchangedWhateverTheSky) {
  Image<Rgba8> picture(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) picture.at(x, y) = Rgba8{(7 * x + 3 * y) % 256, (x * y) % 256, (5 * x) % 256, 255};
  const auto shown = drawn(content(picture), report(40.0));
  for (std::size_t i = 0; i < shown.elements().size(); ++i)
    ASSERT_EQ(shown.elements()[i], Rgb8(picture.elements()[i])) << i;
}

TEST_F(StillPictureTest, TransparentPartsShowThePresentSky) {
  const auto clear = drawn(content(wall()), report(40.0));
  const Rgb8 sky = clear.at(kWidth / 2, 5), ground = clear.at(kWidth / 2, kHeight - 5);
  EXPECT_EQ(ground, (Rgb8{180, 30, 20}));
  EXPECT_GT(sky.b, sky.r + 25) << "blue by day";
  const auto grey = drawn(content(wall()), report(40.0, SkyCondition::overcast)).at(kWidth / 2, 5);
  EXPECT_LT(std::abs(grey.b - grey.r), 12) << "grey under clouds";
  const auto dusk = drawn(content(wall()), report(93.0));
  EXPECT_LT(luminance(dusk.at(kWidth / 2, 5)), 0.85 * luminance(sky)) << "darker at dusk";
  const auto haze = drawn(content(wall()), report(40.0, SkyCondition::clear, 6.0)).at(kWidth / 2, 5);
  EXPECT_LT(haze.b - haze.r, sky.b - sky.r) << "paler in haze";

  std::filesystem::create_directories(test_output_folder());
  for (const auto& [name, picture] : {std::pair{"clear", clear}, std::pair{"dusk", dusk}})
    EXPECT_TRUE(write_png(test_output_folder() / fmt::format("still-{}.png", name), picture));
}

TEST_F(StillPictureTest, WithoutOneThereIsPlainLandUnderTheSky) {
  const auto shown = drawn(content(std::nullopt), report(40.0));
  EXPECT_GT(shown.at(kWidth / 2, 5).b, shown.at(kWidth / 2, 5).r + 25);
  EXPECT_EQ(shown.at(kWidth / 2, kHeight - 5), Rgb8(kStillBackground));
}

TEST_F(StillPictureTest, AtNightOrWithoutTheSunsPositionNoSkyIsShown) {
  auto unknown = report(40.0);
  unknown.sun.source = SunSource::none;
  for (const auto& sky : {unknown, report(110.0), report(80.0, SkyCondition::night)}) {
    const auto shown = drawn(content(std::nullopt), sky);
    EXPECT_EQ(shown.at(kWidth / 2, 5), Rgb8(kStillBackground));
  }
}

TEST_F(StillPictureTest, FadesAsAWhole) {
  auto still = StillPicture::create(*context_, content(wall())).value();
  const auto whole = drawn(still, report(40.0)), half = drawn(still, report(40.0), 0.5);
  for (const auto& pixel : {glm::ivec2{160, 5}, glm::ivec2{20, 60}, glm::ivec2{160, 170}})
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(half.at(pixel.x, pixel.y)[c], 0.5 * whole.at(pixel.x, pixel.y)[c], 1.5) << pixel.x << " " << c;
}

TEST_F(StillPictureTest, IsNotKeptAtTheScreensSizeWhileUnseen) {
  if (!kHeapTells || !context_->info().software) GTEST_SKIP() << "the driver's memory is not this process's";
  auto still = StillPicture::create(*context_, content(wall())).value();
  constexpr int kAcross = 1600, kDown = 900;
  auto target = Offscreen::create(context_->info(), kAcross, kDown).value();
  const auto dot = FlatPicture::create(*context_, Image<Rgba8>(1, 1, Rgba8{9, 9, 9, 255})).value();
  const auto in_use = [&](double opacity) {
    // Being drawn when the still picture's begins: two are in flight.
    for (int i = 0; i < 20; ++i) EXPECT_TRUE(dot.draw(target.target(), everywhere(target.target()), 0.5));
    EXPECT_TRUE(still.draw(target.target(), report(40.0), opacity));
    // As in a kiosk other pictures follow: the driver keeps what was drawn last.
    for (int i = 0; i < 2; ++i) {
      EXPECT_TRUE(dot.draw(target.target(), {0, 0, 8, 8}));
      EXPECT_TRUE(target.read());
    }
    return heap_in_use();
  };
  const double seen = in_use(1.0);
  constexpr double kPrograms = 2e6;  // with the points of its sky
  EXPECT_GT(seen - in_use(0.0), 4.0 * kAcross * kDown + kPrograms);
  EXPECT_NEAR(in_use(1.0), seen, 0.5 * 4.0 * kAcross * kDown) << "and it comes back";
}

TEST_F(StillPictureTest, TheSkyIsRedrawnOnlyWhenItHasChanged) {
  auto still = StillPicture::create(*context_, content(wall())).value();
  const auto first = drawn(still, report(40.0));
  EXPECT_EQ(drawn(still, report(40.1)).elements(), first.elements()) << "a tenth of a degree is not visible";
  EXPECT_NE(drawn(still, report(60.0)).elements(), first.elements());
}

}  // namespace
}  // namespace kasumi
