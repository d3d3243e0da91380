// Who passes before the object: what the mask says is in front comes out as the camera saw it, to the bit.
#include <cmath>

#include "gles/gl/gl.hpp"
#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

class PassersBefore : public GlesTest {
 protected:
  static constexpr int kWidth = 160, kHeight = 120;

  static double light_of(std::uint8_t code) {
    const double c = code / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  }
  static double code_of(double light) {
    return 255.0 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055);
  }
  // A stripe across the box: left half covered, then shares that fall to none. Behind it is `behind`.
  static InFront stripe(Rgb8 behind) {
    InFront made{40, 50, Image<glm::u8vec4>(82, 22, glm::u8vec4{0, 0, 0, 255})};
    for (int y = 1; y < 21; ++y)
      for (int x = 1; x < 81; ++x)
        made.pixels.at(x, y) = glm::u8vec4(behind, x < 40 ? 0 : static_cast<std::uint8_t>((x - 39) * 6));
    return made;
  }
};

TEST_F(PassersBefore, ShowsThemAsTheCameraSawThemAndMixesTheirEdgesInLinearLight) {
  const ReferenceScene scene = box_scene();
  for (const RendererOptions& options : {RendererOptions{}, RendererOptions{.force_promised_units = true}}) {
    Renderer renderer = loaded(scene, options);
    ASSERT_OK(renderer.redraw_layer(scene.appearance));
    const Image<Rgb8> camera = landscape(kWidth, kHeight);
    const Image<Rgb8> alone = draw(renderer, scene.measured, view_of(camera));
    const auto coverage = renderer.read_layer();
    ASSERT_OK(coverage);
    const PixelBox box = renderer.object_box();
    const Rgb8 behind{90, 120, 70};
    const InFront passers = stripe(behind);
    ASSERT_OK(renderer.set_in_front(passers));
    const Image<Rgb8> shown = draw(renderer, scene.measured, view_of(camera));
    int covered = 0, mixed = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const int u = x - passers.left, v = y - passers.top;
        const double open = passers.pixels.contains(u, v) ? passers.pixels.at(u, v).a / 255.0 : 1.0;
        const bool inside = x >= box.left && x < box.right && y >= box.top && y < box.bottom;
        const double share = inside ? double(coverage->at(x - box.left, y - box.top).a) : 0.0;
        if (open == 0.0) {
          ASSERT_EQ(shown.at(x, y), camera.at(x, y)) << x << ", " << y;
          covered += share > 0.99;
        } else if (open == 1.0) {
          for (int c = 0; c < 3; ++c) ASSERT_NEAR(shown.at(x, y)[c], alone.at(x, y)[c], 1) << x << ", " << y;
        } else if (share > 0.999) {
          ++mixed;
          for (int c = 0; c < 3; ++c) {
            const double light =
                light_of(camera.at(x, y)[c]) + open * (light_of(alone.at(x, y)[c]) - light_of(behind[c]));
            ASSERT_NEAR(shown.at(x, y)[c], code_of(std::max(0.0, light)), 2.0) << x << ", " << y;
          }
        }
      }
    EXPECT_GT(covered, 100);
    EXPECT_GT(mixed, 100);
    ASSERT_OK(renderer.set_in_front({}));
    EXPECT_EQ(draw(renderer, scene.measured, view_of(camera)).elements(), alone.elements());
  }
}

TEST_F(PassersBefore, StayInFrontOfLeavesToo) {
  ReferenceScene scene = box_scene();
  scene.mask = Image<std::uint8_t>(kWidth, kHeight, 255);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 60; x < 110; ++x) scene.mask.at(x, y) = 128;
  for (const RendererOptions& options : {RendererOptions{}, RendererOptions{.force_promised_units = true}}) {
    Renderer renderer = loaded(scene, options);
    ASSERT_OK(renderer.redraw_layer(scene.appearance));
    ASSERT_TRUE(renderer.has_matte());
    const Image<Rgb8> camera = landscape(kWidth, kHeight);
    const InFront passers = stripe({90, 120, 70});
    ASSERT_OK(renderer.set_in_front(passers));
    const Image<Rgb8> shown = draw(renderer, scene.measured, view_of(camera));
    for (int v = 1; v < 21; ++v)
      for (int u = 1; u < 40; ++u)
        ASSERT_EQ(shown.at(passers.left + u, passers.top + v), camera.at(passers.left + u, passers.top + v))
            << u << ", " << v;
  }
}

TEST_F(PassersBefore, AreLeftOutOfTheBuildingsPlane) {
  const ReferenceScene scene = box_scene();
  Renderer renderer = loaded(scene);
  ASSERT_OK(renderer.redraw_layer(scene.appearance));
  const Image<Rgb8> camera = landscape(kWidth, kHeight);
  ASSERT_OK(renderer.upload(view_of(camera)));
  const PixelBox box = renderer.object_box();
  const InFront passers = stripe({90, 120, 70});
  ASSERT_OK(renderer.set_in_front(passers));
  Offscreen plane = make_target(box.right - box.left, box.bottom - box.top);
  ASSERT_OK(renderer.draw_for_plane(scene.measured, plane.target()));
  Image<glm::u8vec4> texels(box.right - box.left, box.bottom - box.top);
  glBindFramebuffer(GL_FRAMEBUFFER, plane.target().framebuffer);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, texels.width(), texels.height(), GL_RGBA, GL_UNSIGNED_BYTE, texels.elements().data());
  int opaque = 0;
  for (int y = box.top; y < box.bottom; ++y)
    for (int x = box.left; x < box.right; ++x) {
      const int u = x - passers.left, v = y - passers.top;
      const bool covered = passers.pixels.contains(u, v) && passers.pixels.at(u, v).a == 0;
      const auto texel = texels.at(x - box.left, y - box.top);
      if (covered) {
        ASSERT_EQ(texel, (glm::u8vec4{0, 0, 0, 0})) << x << ", " << y;
      }
      opaque += texel.a == 255;
    }
  EXPECT_GT(opaque, 100);
}

}  // namespace
}  // namespace kasumi
