// The shaders of the sky's dome and of haze that blurs, in 16 bits (as tests/gles/object/test_precision.cpp has the
// building's).
#include <cmath>

#include <gtest/gtest.h>

#include "base/picture.hpp"
#include "gles/air/haze_blur.hpp"
#include "gles/gl/context.hpp"
#include "gles/gl/offscreen.hpp"
#include "pipeline/lab/sky/dome_drawing.hpp"
#include "pipeline/show/scene/haze_blur_for_gles.hpp"
#include "tests/estimator/haze/haze_scenes.hpp"
#include "tests/gles/gl/halves.hpp"
#include "tests/gles/gl/lesser_gl.hpp"
#include "tests/picture_difference.hpp"

namespace kasumi {
namespace {

class AirPrecision : public testing::Test {
 protected:
  void SetUp() override {
    auto opened = open_headless_context();
    if (!opened) GTEST_SKIP() << opened.error().message;
    if (!computes_in_halves()) GTEST_SKIP() << (*opened)->info().renderer << " computes mediump in 32 bits";
  }
};

TEST_F(AirPrecision, OfTheDome) {
  for (const auto projection : {PanoramaProjection::perspective, PanoramaProjection::fisheye})
    for (const double sun_deg : {projection == PanoramaProjection::fisheye ? 8.0 : 50.0}) {
      Viewpoint camera;
      camera.projection = projection;
      camera.width = projection == PanoramaProjection::fisheye ? 1080 : 1920;
      camera.height = 1080;
      camera.pitch_deg = 20.0;
      DomeRequest sky;
      const double azimuth = from_degrees(20.0).value, height = from_degrees(sun_deg).value;
      sky.sun = {std::sin(azimuth) * std::cos(height), std::cos(azimuth) * std::cos(height), std::sin(height)};
      sky = standing_on_land(camera, sky);
      const auto land = land_for(camera, sky.altitude_m, true);
      const auto scene = scene_seen(camera, sky, land ? &*land : nullptr);
      const auto drawn_in = [&](FragmentPrecision precision) {
        const LesserGl gl(precision);
        return DomeDrawing::by_gpu().value().draw(view_of(camera), scene, land ? &*land : nullptr).value();
      };
      const auto exact = drawn_in(FragmentPrecision::high);
      // Of a fisheye, whose rim is off by half a pixel in 16 bits: without the rim.
      const auto without_rim = [&](Image<Rgb8> picture) {
        if (projection != PanoramaProjection::fisheye) return picture;
        for (int y = 0; y < picture.height(); ++y)
          for (int x = 0; x < picture.width(); ++x)
            if (std::abs(std::hypot(x - 539.5, y - 539.5) - 540.0) < 2.0) picture.at(x, y) = {};
        return picture;
      };
      for (const auto precision : {FragmentPrecision::driver, FragmentPrecision::medium}) {
        const int off = difference(without_rim(drawn_in(precision)), without_rim(exact)).largest;
        fmt::print("{}, sun {} deg high, {}: {} of 255\n", name_of(projection), sun_deg,
                   precision == FragmentPrecision::medium ? "all in 16 bits" : "as written", off);
        EXPECT_LE(off, 2);
      }
    }
}

TEST_F(AirPrecision, OfHazeThatBlurs) {
  constexpr int kWide = 240, kTall = 160;
  const auto pattern = bars(kWide, kTall);
  Image<glm::vec3> light(kWide, kTall);
  Image<float> range_m(kWide, kTall);
  for (int y = 0; y < kTall; ++y)
    for (int x = 0; x < kWide; ++x) {
      light.at(x, y) = glm::vec3(pattern.at(x, y));
      range_m.at(x, y) = x > 60 && x < 90 ? 12.0F : 600.0F / static_cast<float>(y + 10);
    }
  const auto range = prepare_range(range_m).value();
  const glm::dvec3 airlight{0.75, 0.8, 0.85};
  const auto look = haze_look(haze_optics(0.2, 0.3, 20.0), range, airlight);
  const auto drawn_in = [&](FragmentPrecision precision, bool in_bytes) {
    const LesserGl gl(precision);
    const auto context = open_headless_context().value();
    auto blur = HazeBlur::create(context->info(), kWide, kTall, {in_bytes}).value();
    EXPECT_TRUE(blur.set_scene(haze_scene(light, range)));
    EXPECT_TRUE(blur.run(look));
    auto target = Offscreen::create(context->info(), kWide, kTall).value();
    EXPECT_TRUE(blur.show(target.target()));
    return target.read().value();
  };
  for (const bool in_bytes : {false, true}) {
    const int off =
        difference(drawn_in(FragmentPrecision::driver, in_bytes), drawn_in(FragmentPrecision::high, in_bytes)).largest;
    fmt::print("haze {}: {} of 255\n", in_bytes ? "in bytes" : "in half floats", off);
    EXPECT_LE(off, 2);
  }
  // It needs more than 16 bits: without them it is refused, and nothing is drawn that would be wrong.
  const LesserGl gl(FragmentPrecision::medium);
  const auto context = open_headless_context().value();
  const auto refused = HazeBlur::create(context->info(), kWide, kTall);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::unsupported);
}

}  // namespace
}  // namespace kasumi
