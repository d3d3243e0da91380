// GL contexts, and the owners of their objects.
#include <cstdlib>

#include "gles/display/window.hpp"
#include "gles/gl/gl.hpp"
#include "gles/gl/objects.hpp"
#include "tests/environment.hpp"
#include "tests/gles/scenes.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

class Contexts : public GlesTest {};

TEST_F(Contexts, IdentifyThemselves) {
  EXPECT_FALSE(info().renderer.empty());
  EXPECT_THAT(info().version, testing::StartsWith("OpenGL ES"));
  EXPECT_GE(info().es_major, 2);
  EXPECT_GE(info().max_texture_size, 64);  // what GLES 2 guarantees
  EXPECT_EQ(info().software, info().renderer.find("llvmpipe") != std::string::npos ||
                                 info().renderer.find("softpipe") != std::string::npos);
  EXPECT_FALSE(info().has("GL_NO_such_extension"));
}

TEST_F(Contexts, DrawAlikeOnEachSurface) {
  const ReferenceScene scene = box_scene();
  const Image<Rgb8> camera = landscape(160, 120);
  std::vector<Image<Rgb8>> pictures;
  for (const auto surface : {HeadlessSurface::surfaceless, HeadlessSurface::pbuffer}) {
    auto context = open_headless_context(surface);
    if (!context) continue;  // without any context the fixture has skipped already
    context_ = std::move(*context);
    Renderer renderer = loaded(scene);
    pictures.push_back(draw(renderer, scene.measured, view_of(camera)));
  }
  ASSERT_FALSE(pictures.empty());
  EXPECT_EQ(pictures.front().elements(), pictures.back().elements());
}

TEST_F(Contexts, AreIndependentOfEachOthersLifetimes) {
  auto second = open_headless_context();
  ASSERT_OK(second);
  second->reset();
  ASSERT_OK(context_->make_current());
  Offscreen target = make_target(4, 4);
  ASSERT_OK(target.read());
}

TEST_F(Contexts, DeleteEachObjectOnceWithItsLastOwner) {
  unsigned name = 0;
  {
    GlTexture texture = make_texture();
    glBindTexture(GL_TEXTURE_2D, texture.name());
    name = texture.name();
    GlTexture owner = std::move(texture);
    EXPECT_FALSE(texture);  // NOLINT(bugprone-use-after-move): the moved-from state is under test
    EXPECT_EQ(owner.name(), name);
    EXPECT_TRUE(glIsTexture(name));
  }
  EXPECT_FALSE(glIsTexture(name));
}

TEST_F(Contexts, ReportEachGlErrorOnceAsAFault) {
  glEnable(0xdead);
  glViewport(0, 0, -1, -1);
  EXPECT_THAT(check_gl("breaking things"), FailsAs(FaultKind::device, HasSubstr("breaking things: GL_INVALID")));
  EXPECT_TRUE(check_gl("nothing").has_value());
}

TEST_F(Contexts, ReportShaderErrorsWithTheDriversMessage) {
  const std::string vertex = "#version 100\nattribute vec2 p;\nvoid main() { gl_Position = vec4(p, 0.0, 1.0); }\n";
  const auto wrong =
      link_program("wrong.frag", vertex, "#version 100\nvoid main() { gl_FragColor = no_such_thing; }\n", {});
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, testing::AllOf(HasSubstr("wrong.frag"), HasSubstr("no_such_thing")));
  const auto unlinked = link_program(
      "unlinked", vertex,
      "#version 100\nprecision mediump float;\nvarying vec3 v;\nvoid main() { gl_FragColor = vec4(v, 1.0); }\n", {});
  ASSERT_FALSE(unlinked);
  EXPECT_THAT(unlinked.error().message, HasSubstr("unlinked"));
}

TEST(DeskWindow, ShowsAPictureAndCloses) {
  auto window = open_window({.title = "Kasumi test", .width = 200, .height = 100, .wait_for_refresh = false});
  std::optional<EnvironmentVariable> driver;
  if (!window) {
    const std::string no_display = window.error().message;
    EXPECT_EQ(window.error().kind, FaultKind::unsupported);
    // SDL's offscreen driver still provides a context where EGL does.
    driver.emplace("SDL_VIDEODRIVER", "offscreen");
    window = open_window({.title = "Kasumi test", .width = 200, .height = 100, .wait_for_refresh = false});
    if (!window) GTEST_SKIP() << no_display << "; " << window.error().message;
  }
  auto renderer = Renderer::create(**window);
  ASSERT_OK(renderer);
  const Image<Rgb8> picture(40, 30, Rgb8{10, 200, 30});
  ASSERT_OK(renderer->upload(view_of(picture)));
  const DrawTarget target = (*window)->target();
  ASSERT_GT(target.width, 0);
  ASSERT_OK(renderer->draw_background(target));
  std::array<std::uint8_t, 4> middle{};
  glReadPixels(target.width / 2, target.height / 2, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, middle.data());
  EXPECT_EQ(middle[0], 10);
  EXPECT_EQ(middle[1], 200);
  EXPECT_EQ(middle[2], 30);
  (*window)->show();
  EXPECT_TRUE((*window)->handle_events());
}

TEST(DeskWindow, ReportsAMissingDisplay) {
  const EnvironmentVariable driver("SDL_VIDEODRIVER", "no-such-driver");
  const auto window = open_window({});
  ASSERT_FALSE(window);
  EXPECT_EQ(window.error().kind, FaultKind::unsupported);
  EXPECT_THAT(window.error().message, HasSubstr("no-such-driver"));
}

}  // namespace
}  // namespace kasumi
