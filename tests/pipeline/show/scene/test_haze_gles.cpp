// Haze on the GPU against the reference on the CPU, with half floats and without.
#include <cmath>
#include <cstdio>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gles/gl/offscreen.hpp"
#include "pipeline/show/scene/haze_blur_for_gles.hpp"
#include "tests/estimator/haze/haze_scenes.hpp"

namespace kasumi {
namespace {

constexpr int kFrameWidth = 240, kFrameHeight = 160;

// A floor in perspective, a wall, two objects in front of it, sky.
struct Scene {
  Image<glm::vec3> light{kFrameWidth, kFrameHeight};
  HazeRange range;
};
Scene scene() {
  Scene made;
  const auto pattern = bars(kFrameWidth, kFrameHeight);
  Image<float> range_m(kFrameWidth, kFrameHeight);
  for (int y = 0; y < kFrameHeight; ++y)
    for (int x = 0; x < kFrameWidth; ++x) {
      range_m.at(x, y) = y < 30 ? 0.0F : y < 90 ? 60.0F : 600.0F / static_cast<float>(y - 80);
      if (x > 60 && x < 90 && y > 15) range_m.at(x, y) = 12.0F;
      if (x > 150 && x < 153 && y > 40) range_m.at(x, y) = 25.0F;
      made.light.at(x, y) = y < 30 ? glm::vec3(0.6F, 0.7F, 0.95F) : glm::vec3(pattern.at(x, y));
    }
  made.range = prepare_range(range_m).value();
  return made;
}

double psnr(const Image<glm::vec4>& one, const Image<glm::vec4>& other) {
  double sum = 0.0;
  for (std::size_t i = 0; i < one.elements().size(); ++i) {
    const glm::dvec4 off = glm::dvec4(one.elements()[i]) - glm::dvec4(other.elements()[i]);
    sum += off.r * off.r + off.g * off.g + off.b * off.b + off.a * off.a;
  }
  return -10.0 * std::log10(sum / (4.0 * static_cast<double>(one.elements().size())));
}

class HazeOnGpu : public testing::Test {
 protected:
  void SetUp() override {
    auto opened = open_headless_context();
    if (!opened) GTEST_SKIP() << opened.error().message;
    context = std::move(*opened);
  }
  Image<glm::vec4> on_gpu(const Scene& s, const HazeLook& look, bool force_bytes) {
    auto blur = HazeBlur::create(context->info(), kFrameWidth, kFrameHeight, {force_bytes});
    if (!blur) ADD_FAILURE() << blur.error().message;
    EXPECT_TRUE(blur->set_scene(haze_scene(s.light, s.range)));
    const auto run = blur->run(look);
    EXPECT_TRUE(run) << run.error().message;
    return blur->read().value();
  }
  bool half_floats() const {
    return context->info().has("GL_EXT_color_buffer_half_float") || context->info().has("GL_EXT_color_buffer_float");
  }
  std::unique_ptr<GlContext> context;
  const glm::dvec3 airlight{0.75, 0.8, 0.85};
};

TEST_F(HazeOnGpu, MatchesTheReferenceWithHalfFloatsAndWithBytes) {
  const auto s = scene();
  HazeOptics unequal = haze_optics(0.0, 0.4, 35.0);
  unequal.extinction = {glm::dvec3(0.3, 0.5, 0.9), glm::dvec3(0.4, 0.7, 1.4)};
  unequal.weight = {glm::dvec3(0.6), glm::dvec3(0.4)};
  for (const auto& optics : {haze_optics(0.25, 0.25, 15.0), haze_optics(0.0, 0.3, 40.0), unequal}) {
    const auto map = blur_map(s.range, optics);
    const auto faded = attenuated(s.light, s.range.range, optics, airlight);
    const auto truth = diffuse(DiffusionScheme::matched, faded, map).value();
    const auto look = haze_look(optics, s.range, airlight);
    const double in_bytes = psnr(on_gpu(s, look, true), truth);
    const double blurred = psnr(faded, truth);
    std::printf("%zu passes, bytes: %.1f dB (not blurred at all: %.1f dB)\n", look.passes.size(), in_bytes, blurred);
    EXPECT_GE(in_bytes, 80.0);
    EXPECT_LT(blurred, 40.0) << "otherwise the test shows nothing";
    if (!half_floats()) continue;
    const double in_halves = psnr(on_gpu(s, look, false), truth);
    std::printf("   half floats: %.1f dB\n", in_halves);
    EXPECT_GE(in_halves, 60.0);
  }
}

TEST_F(HazeOnGpu, MatchesTheReferenceInTheExplicitScheme) {
  const auto s = scene();
  const auto optics = haze_optics(0.1, 0.3, 6.0);  // 5.6 px in the sky: 61 passes
  const auto truth = diffuse(DiffusionScheme::explicit_steps, attenuated(s.light, s.range.range, optics, airlight),
                             blur_map(s.range, optics))
                         .value();
  const auto look = haze_look(optics, s.range, airlight, DiffusionScheme::explicit_steps);
  EXPECT_EQ(look.explicit_passes, passes_of(DiffusionScheme::explicit_steps, 1.0, optics.sigma_px(1.25)));
  EXPECT_GE(psnr(on_gpu(s, look, true), truth), 80.0);
  // H Fig 6: rounding to half floats adds up over many passes.
  if (!half_floats()) return;
  EXPECT_GE(psnr(on_gpu(s, look, false), truth), 50.0);
}

TEST_F(HazeOnGpu, DoesNotLeakAcrossEdges) {
  for (const bool bright : {true, false}) {
    const auto object = object_before_wall(kFrameHeight, 0.3F, bright ? 1.0F : 0.0F, bright ? 0.0F : 1.0F);
    Scene s;
    s.light = Image<glm::vec3>(kFrameWidth, kFrameHeight, glm::vec3(bright ? 0.0F : 1.0F));
    Image<float> range_m(kFrameWidth, kFrameHeight, 100.0F);
    for (int y = 0; y < kFrameHeight; ++y)
      for (int x = 0; x < kFrameHeight; ++x) {
        range_m.at(x, y) = 100.0F * object.range.at(x, y);
        s.light.at(x, y) = glm::vec3(object.light.at(x, y));
      }
    s.range = prepare_range(range_m).value();
    auto optics = haze_optics(0.0, 0.25, 30.0);
    optics.extinction.fill(glm::dvec3{0.0});  // nothing fades: only the blur is left
    for (const bool bytes : {true, false}) {
      if (!bytes && !half_floats()) continue;
      const auto blurred = on_gpu(s, haze_look(optics, s.range, airlight), bytes);
      double worst = 0.0;
      for (int y = 0; y < kFrameHeight; ++y)
        for (int x = 0; x < kFrameWidth; ++x)
          worst = std::max(worst, static_cast<double>(std::abs(blurred.at(x, y).r - s.light.at(x, y).r)));
      EXPECT_EQ(worst, 0.0) << (bytes ? "bytes" : "half floats");
    }
  }
}

TEST_F(HazeOnGpu, CompositesLikeTheReference) {
  const auto s = scene();
  const auto optics = haze_optics(0.2, 0.3, 20.0);
  const auto truth = under_haze(s.light, s.range, optics, airlight, DiffusionScheme::matched).value();
  for (const bool bytes : {true, false}) {
    if (!bytes && !half_floats()) continue;
    auto blur = HazeBlur::create(context->info(), kFrameWidth, kFrameHeight, {bytes}).value();
    ASSERT_TRUE(blur.set_scene(haze_scene(s.light, s.range)));
    ASSERT_TRUE(blur.run(haze_look(optics, s.range, airlight)));
    auto offscreen = Offscreen::create(context->info(), kFrameWidth, kFrameHeight).value();
    ASSERT_TRUE(blur.show(offscreen.target()));
    const auto seen = offscreen.read().value();
    double worst = 0.0;
    for (int y = 0; y < kFrameHeight; ++y)
      for (int x = 0; x < kFrameWidth; ++x)
        for (int c = 0; c < 3; ++c) {
          const auto light = std::min(static_cast<double>(truth.light.at(x, y)[c]), 1.0);
          const double encoded = light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055;
          worst = std::max(worst, std::abs(seen.at(x, y)[c] - 255.0 * encoded));
        }
    EXPECT_LT(worst, 2.0) << "of 255";
  }
}

TEST_F(HazeOnGpu, ReportsProblems) {
  auto blur = HazeBlur::create(context->info(), 8, 6).value();
  EXPECT_FALSE(blur.run({})) << "no picture yet";
  BlurInput wrong{Image<glm::vec3>(8, 6), Image<float>(8, 5), Image<float>(7, 6), Image<float>(8, 6)};
  const auto set = blur.set_scene(wrong);
  ASSERT_FALSE(set);
  EXPECT_THAT(set.error().message, testing::AllOf(testing::HasSubstr("8 x 5"), testing::HasSubstr("7 x 6")));
  EXPECT_FALSE(HazeBlur::create(context->info(), 0, 6));
  ASSERT_TRUE(
      blur.set_scene({Image<glm::vec3>(8, 6), Image<float>(8, 6, 1.0F), Image<float>(8, 6), Image<float>(8, 6)}));
  HazeLook far;
  far.passes.push_back({7.0, 0.0, 20.0});
  EXPECT_FALSE(blur.run(far));
}

}  // namespace
}  // namespace kasumi
