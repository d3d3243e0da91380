// Captions and stills: flat pictures blended over a target's content.
#include <cmath>
#include <random>

#include "gles/gl/gl.hpp"
#include "gles/picture/flat_picture.hpp"
#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

class FlatPictures : public GlesTest {
 protected:
  FlatPicture make(const Image<Rgba8>& picture) {
    auto made = FlatPicture::create(*context_, picture);
    EXPECT_TRUE(made.has_value()) << (made ? "" : made.error().message);
    return std::move(*made);
  }
};

Image<Rgba8> noise(int width, int height) {
  std::mt19937_64 random(11);
  Image<Rgba8> picture(width, height);
  for (Rgba8& p : picture.elements())
    for (int c = 0; c < 4; ++c) p[c] = static_cast<std::uint8_t>(random() >> 56);
  return picture;
}

const glm::dvec3 kGround{51.0, 102.0, 204.0};

Rgb8 blended(const glm::dvec4& over, double opacity) {  // colours not multiplied by alpha
  const double alpha = over.a / 255.0 * opacity;
  const glm::dvec3 sum = glm::dvec3(over) * alpha + kGround * (1.0 - alpha);
  return Rgb8(glm::round(sum));
}

int largest_difference(const Rgb8& a, const Rgb8& b) {
  return std::max({std::abs(a.r - b.r), std::abs(a.g - b.g), std::abs(a.b - b.b)});
}

// Each program takes software GL a megabyte, whatever it draws.
TEST_F(FlatPictures, ShareOneProgram) {
  const auto programs = [] {
    int count = 0;
    for (GLuint name = 1; name < 4096; ++name) count += glIsProgram(name) == GL_TRUE;
    return count;
  };
  const Image<Rgba8> picture = noise(8, 8);
  const int before = programs();
  {
    const FlatPicture one = make(picture);
    const FlatPicture other = make(picture);
    EXPECT_EQ(programs(), before + 1);
  }
  EXPECT_EQ(programs(), before);
  const FlatPicture again = make(picture);
  EXPECT_EQ(programs(), before + 1);
}

TEST_F(FlatPictures, BlendEachPixelOverTheTargetInFilesAndWindowsAlike) {
  const Image<Rgba8> picture = noise(37, 21);
  const FlatPicture flat = make(picture);
  Offscreen offscreen = make_target(64, 48);
  for (const bool window : {false, true})
    for (const double opacity : {1.0, 0.4, 0.0}) {
      DrawTarget target = offscreen.target();
      target.top_row_first = !window;
      clear_to(target, glm::vec3(kGround / 255.0));
      ASSERT_OK(flat.draw(target, {5, 9, 37, 21}, opacity));
      const auto drawn = offscreen.read();
      ASSERT_OK(drawn);
      int worst = 0;
      for (int y = 0; y < 48; ++y)
        for (int x = 0; x < 64; ++x) {
          const bool inside = picture.contains(x - 5, y - 9);
          const Rgb8 expected = inside ? blended(glm::dvec4(picture.at(x - 5, y - 9)), opacity) : Rgb8(kGround);
          worst = std::max(worst, largest_difference(drawn->at(x, window ? 47 - y : y), expected));
        }
      EXPECT_LE(worst, 1) << "steps of 255, " << (window ? "window" : "file") << ", opacity " << opacity;
    }
}

TEST_F(FlatPictures, AreInterpolatedBetweenPixelsAndClampedAtTheirEdges) {
  const Image<Rgba8> picture = noise(6, 5);
  const FlatPicture flat = make(picture);
  Offscreen offscreen = make_target(40, 40);
  clear_to(offscreen.target(), glm::vec3(kGround / 255.0));
  ASSERT_OK(flat.draw(offscreen.target(), {4, 8, 30, 25}));
  const auto drawn = offscreen.read();
  ASSERT_OK(drawn);
  const auto texel = [&](int x, int y) {
    const glm::dvec4 p(picture.at(std::clamp(x, 0, 5), std::clamp(y, 0, 4)));
    return glm::dvec4(glm::dvec3(p) * (p.a / 255.0), p.a);
  };
  int worst = 0;
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 40; ++x) {
      Rgb8 expected(kGround);
      if (x >= 4 && x < 34 && y >= 8 && y < 33) {
        const double u = (x - 4 + 0.5) / 5.0 - 0.5, v = (y - 8 + 0.5) / 5.0 - 0.5;
        const int left = static_cast<int>(std::floor(u)), top = static_cast<int>(std::floor(v));
        const glm::dvec4 upper = glm::mix(texel(left, top), texel(left + 1, top), u - left);
        const glm::dvec4 lower = glm::mix(texel(left, top + 1), texel(left + 1, top + 1), u - left);
        const glm::dvec4 over = glm::mix(upper, lower, v - top);
        expected = Rgb8(glm::round(glm::dvec3(over) + kGround * (1.0 - over.a / 255.0)));
      }
      worst = std::max(worst, largest_difference(drawn->at(x, y), expected));
    }
  EXPECT_LE(worst, 2) << "steps of 255";
}

TEST_F(FlatPictures, NeverShowTheColourOfATransparentPixel) {
  Image<Rgba8> picture(4, 4, Rgba8{255, 0, 0, 0});
  picture.at(1, 1) = picture.at(2, 1) = picture.at(1, 2) = picture.at(2, 2) = {255, 255, 255, 255};
  const FlatPicture flat = make(picture);
  Offscreen offscreen = make_target(32, 32);
  clear_to(offscreen.target(), {1, 1, 1});
  ASSERT_OK(flat.draw(offscreen.target(), {0, 0, 32, 32}));
  const auto drawn = offscreen.read();
  ASSERT_OK(drawn);
  int darkest = 255;
  for (const Rgb8& p : drawn->elements()) darkest = std::min({darkest, int(p.r), int(p.g), int(p.b)});
  EXPECT_GE(darkest, 254) << "white over white stays white";
}

TEST_F(FlatPictures, AreAveragedWhereTheyShrink) {
  // Stripes one pixel wide, 16 times smaller: grey, and no stripes of a wrong width.
  Image<Rgba8> stripes(512, 256, Rgba8{0, 0, 0, 255});
  for (int y = 0; y < 256; ++y)
    for (int x = 0; x < 512; x += 2) stripes.at(x, y) = {255, 255, 255, 255};
  const FlatPicture flat = make(stripes);
  Offscreen offscreen = make_target(32, 16);
  ASSERT_OK(flat.draw(offscreen.target(), {0, 0, 32, 16}));
  const auto drawn = offscreen.read();
  ASSERT_OK(drawn);
  for (const Rgb8& p : drawn->elements()) ASSERT_NEAR(p.g, 127.5, 2.0);
}

TEST_F(FlatPictures, AreHalvedWhenTooLargeForTheDriver) {
  const int width = 2 * info().max_texture_size + 2;
  Image<Rgba8> strip(width, 2, Rgba8{0, 0, 0, 255});
  for (int y = 0; y < 2; ++y)
    for (int x = width / 2; x < width; ++x) strip.at(x, y) = {250, 100, 50, 255};
  const FlatPicture flat = make(strip);
  EXPECT_EQ(flat.width(), width);
  EXPECT_EQ(flat.height(), 2);
  Offscreen offscreen = make_target(64, 8);
  ASSERT_OK(flat.draw(offscreen.target(), {0, 0, 64, 8}));
  const auto drawn = offscreen.read();
  ASSERT_OK(drawn);
  EXPECT_EQ(drawn->at(8, 4), Rgb8(0, 0, 0));
  EXPECT_EQ(drawn->at(56, 4), Rgb8(250, 100, 50));
}

TEST_F(FlatPictures, FitWhereTheCamerasPictureWouldBe) {
  // A white camera picture, then a black still of the same shape over it: nothing white may be left.
  Renderer renderer = make_renderer();
  const Image<Rgb8> white(40, 30, Rgb8{255, 255, 255});
  const FlatPicture black = make(Image<Rgba8>(80, 60, Rgba8{0, 0, 0, 255}));
  ASSERT_OK(renderer.upload(view_of(white)));
  for (const auto& [width, height] : {std::pair{101, 30}, {40, 91}, {57, 41}})
    for (const bool window : {false, true}) {
      Offscreen offscreen = make_target(width, height);
      DrawTarget target = offscreen.target();
      target.top_row_first = !window;
      ASSERT_OK(renderer.draw_background(target));
      const FlatPlace place = fitted(target, 80, 60);
      EXPECT_NEAR(place.width / place.height, 4.0 / 3.0, 0.03);
      EXPECT_TRUE(place.width == width || place.height == height);
      ASSERT_OK(black.draw(target, place));
      const auto drawn = offscreen.read();
      ASSERT_OK(drawn);
      for (const Rgb8& p : drawn->elements()) ASSERT_EQ(p, Rgb8(0, 0, 0)) << width << " x " << height;
    }
}

TEST_F(FlatPictures, LeaveTheSceneDrawnBeforeUnchanged) {
  // Drawn between two composites, a caption must not leak its GL state into the second.
  ReferenceScene scene = box_scene();
  Renderer renderer = loaded(scene);
  const Image<Rgb8> camera = landscape(160, 120);
  const Image<Rgb8> before = draw(renderer, scene.measured, view_of(camera));
  Offscreen offscreen = make_target(160, 120);
  ASSERT_OK(make(noise(20, 10)).draw(offscreen.target(), {3.5, 4.25, 50, 20}, 0.7));
  EXPECT_EQ(before.elements(), draw(renderer, scene.measured, view_of(camera)).elements());
}

TEST_F(FlatPictures, RefuseInvalidPictures) {
  EXPECT_EQ(FlatPicture::create(*context_, Image<Rgba8>()).error().kind, FaultKind::bad_input);
  const FlatPicture flat = make(noise(4, 4));
  Offscreen offscreen = make_target(8, 8);
  DrawTarget nothing = offscreen.target();
  nothing.width = 0;
  EXPECT_EQ(flat.draw(nothing, {0, 0, 4, 4}).error().kind, FaultKind::bad_input);
  EXPECT_EQ(flat.draw(offscreen.target(), {0, 0, 0, 4}).error().kind, FaultKind::bad_input);
  EXPECT_EQ(flat.draw(offscreen.target(), {std::nan(""), 0, 4, 4}).error().kind, FaultKind::bad_input);
}

}  // namespace
}  // namespace kasumi
