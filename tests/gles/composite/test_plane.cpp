// The building as a display lays it over the camera's picture by itself, against the picture that draw() makes.
#include <algorithm>
#include <cmath>

#include "gles/gl/gl.hpp"
#include "tests/figures.hpp"
#include "tests/gles/scenes.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

struct Difference {
  double psnr_db = 0.0;  // of the object's box
  int opaque = 0;        // in steps, at worst
  int edge = 0;
  int edges = 0;  // partly transparent pixels seen
};

class PlaneOfTheBuilding : public GlesTest {
 protected:
  // A box with a wing of glass on ground that it shades, seen from above behind a foreground with soft edges.
  static ReferenceScene scene() {
    ReferenceScene made;
    made.view = view_north(160, 120, 1400);
    const double pitch = std::atan2(-350.0, 600.0), c = std::cos(pitch), s = std::sin(pitch);
    made.view.world_to_camera = glm::dmat4({1, 0, 0, 0}, {0, s, c, 0}, {0, -c, s, 0}, {0, 0, 0, 1});
    made.model.parts = {box_part({-12, 0, -10}, {12, 22, 10}, 4), box_part({-24, 0, -8}, {-12, 14, 8}, 4, 1)};
    made.model.ground = {box_part({-60, -1, -60}, {60, 0, 60}, 8, 2)};
    made.model.materials = {
        {.name = "plaster", .base_colour = {0.7f, 0.6f, 0.45f, 1.0f}},
        {.name = "glass", .base_colour = {0.5f, 0.6f, 0.6f, 0.4f}, .alpha = ModelMaterial::Alpha::blend},
        {.name = "ground", .base_colour = {0.2f, 0.2f, 0.2f, 1.0f}}};
    made.model_to_world = model_to_world({0, 600, -350, from_degrees(25), 1.0});
    made.appearance = afternoon(made.view);
    made.appearance.shadows = true;
    made.measured = measured_airlight(made.view);
    made.mask = Image<std::uint8_t>(made.view.width, made.view.height, 255);
    for (int y = 0; y < made.view.height; ++y)
      for (int x = 0; x < 70; ++x) made.mask.at(x, y) = static_cast<std::uint8_t>(std::clamp((x - 40) * 12, 0, 255));
    return made;
  }

  Image<glm::u8vec4> draw_plane(Renderer& renderer, const ReferenceScene& scene, const SensorNoise& noise) {
    const PixelBox box = renderer.object_box();
    Offscreen target = make_target(box.right - box.left, box.bottom - box.top);
    const auto drawn = renderer.draw_for_plane(scene.measured, target.target(), noise);
    if (!drawn) throw std::runtime_error(drawn.error().message);
    Image<glm::u8vec4> plane(box.right - box.left, box.bottom - box.top);
    glBindFramebuffer(GL_FRAMEBUFFER, target.target().framebuffer);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadPixels(0, 0, plane.width(), plane.height(), GL_RGBA, GL_UNSIGNED_BYTE, plane.elements().data());
    return plane;
  }
  // As displays blend: premultiplied, encoded, rounded once.
  static Rgb8 over(glm::u8vec4 above, Rgb8 below) {
    Rgb8 sum;
    for (int c = 0; c < 3; ++c)
      sum[c] = static_cast<std::uint8_t>(
          std::min(255, above[c] + static_cast<int>(std::lround((255 - above.a) * below[c] / 255.0))));
    return sum;
  }
  // The plane, drawn over `then`, lies over `now`.
  Difference compare(Renderer& renderer, const ReferenceScene& scene, const Image<Rgb8>& then, const Image<Rgb8>& now,
                     const SensorNoise& noise = {}) {
    EXPECT_TRUE(renderer.upload(view_of(then)));
    const auto plane = draw_plane(renderer, scene, noise);
    Offscreen target = make_target(now.width(), now.height());
    EXPECT_TRUE(renderer.upload(view_of(now)));
    EXPECT_TRUE(renderer.draw(scene.measured, target.target(), noise));
    const auto picture = target.read().value();
    const PixelBox box = renderer.object_box();
    const bool same = then.elements() == now.elements();
    Difference found;
    double squares = 0.0;
    for (int y = 0; y < plane.height(); ++y)
      for (int x = 0; x < plane.width(); ++x) {
        const glm::u8vec4 above = plane.at(x, y);
        const Rgb8 want = picture.at(box.left + x, box.top + y), is = over(above, now.at(box.left + x, box.top + y));
        for (int c = 0; c < 3; ++c) {
          EXPECT_LE(above[c], above.a) << "premultiplied, at " << x << ", " << y;
          // Leaves that move are drawn again with every picture.
          const auto mask = scene.mask.empty() ? 255 : scene.mask.at(box.left + x, box.top + y);
          if (mask != 0 && mask != 255 && !same) continue;
          const int off = std::abs(int{want[c]} - int{is[c]});
          squares += off * off;
          int& worst = above.a == 255 ? found.opaque : found.edge;
          worst = std::max(worst, off);
        }
        if (above.a > 0 && above.a < 255) ++found.edges;
      }
    found.psnr_db = 10.0 * std::log10(255.0 * 255.0 * 3.0 * double(plane.elements().size()) / std::max(squares, 1e-9));
    return found;
  }
  // Every pixel darker or brighter by `steps`, each for itself.
  static Image<Rgb8> moved(Image<Rgb8> picture, int steps) {
    unsigned random = 1;
    for (Rgb8& pixel : picture.elements()) {
      random = random * 1664525u + 1013904223u;
      const int by = (random >> 16 & 1u) != 0 ? steps : -steps;
      for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>(std::clamp(pixel[c] + by, 0, 255));
    }
    return picture;
  }
};

TEST_F(PlaneOfTheBuilding, GivesDrawsPictureOverTheSameBackground) {
  for (const bool table : {false, true})
    for (const bool blurred : {false, true}) {
      ReferenceScene made = scene();
      if (table) {
        made.response.kind = ResponseCurve::Kind::table;
        for (auto& channel : made.response.light)
          for (int i = 0; i < 64; ++i) channel.push_back(std::pow(i / 63.0, 1.9));
      }
      Renderer renderer = make_renderer();
      if (blurred) ASSERT_OK(renderer.set_detail({1.2, 2, 2}));
      load(renderer, made);
      for (const SensorNoise& noise : {SensorNoise{}, SensorNoise{glm::dvec3{0.0005}, glm::dvec3{0.003}, 5}}) {
        const auto camera = landscape(made.view.width, made.view.height);
        const auto found = compare(renderer, made, camera, camera, noise);
        EXPECT_EQ(found.opaque, 0);
        EXPECT_LE(found.edge, 1);
        EXPECT_GE(found.psnr_db, 45.0);
        EXPECT_GT(found.edges, 500) << "edges, glass and shadow";
      }
    }
}

// Also where the building is much brighter or darker than what lies behind its edges.
TEST_F(PlaneOfTheBuilding, FollowsABackgroundThatMoves) {
  ReferenceScene made = scene();
  Renderer renderer = loaded(made);
  const auto measured = made.measured;
  for (const double light : {0.25, 1.0})
    for (const int darker : {1, 4}) {
      std::vector<std::string> row{fmt::format("{}, {}", light < 1.0 ? "dark building" : "bright building",
                                               darker == 1 ? "bright background" : "dark background")};
      auto camera = landscape(made.view.width, made.view.height);
      for (Rgb8& pixel : camera.elements())
        for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>(pixel[c] / darker);
      for (std::size_t i = 0; i < measured.light.size(); ++i) made.measured.light[i] = light * measured.light[i];
      for (const int steps : {0, 4, 16}) {
        const auto found = compare(renderer, made, camera, moved(camera, steps));
        row.push_back(fmt::format("{}; {:.1f} dB", found.edge, found.psnr_db));
        EXPECT_EQ(found.opaque, 0) << row[0] << ", moved by " << steps;
        EXPECT_LE(found.edge, steps == 0 ? 1 : 4) << row[0] << ", moved by " << steps;
        EXPECT_GE(found.psnr_db, 45.0) << row[0] << ", moved by " << steps;
      }
      figure_row("planes", row);
    }
}

TEST_F(PlaneOfTheBuilding, LiesInTheBoxThatItTells) {
  const ReferenceScene made = scene();
  Renderer renderer = make_renderer();
  EXPECT_TRUE(renderer.drawn_box().empty());
  load(renderer, made);
  ASSERT_OK(renderer.upload(view_of(landscape(made.view.width, made.view.height))));
  const auto plane = draw_plane(renderer, made, {});
  const PixelBox all = renderer.object_box(), drawn = renderer.drawn_box();
  EXPECT_GT(drawn.left, all.left) << "the foreground hides what lies further left";
  int outside = 0, inside = 0;
  for (int y = all.top; y < all.bottom; ++y)
    for (int x = all.left; x < all.right; ++x) {
      const bool in = x >= drawn.left && x < drawn.right && y >= drawn.top && y < drawn.bottom;
      if (plane.at(x - all.left, y - all.top) != glm::u8vec4(0)) ++(in ? inside : outside);
    }
  EXPECT_EQ(outside, 0);
  EXPECT_GT(inside, 1000);
  ASSERT_OK(renderer.set_foreground({}));
  EXPECT_TRUE(renderer.drawn_box().empty()) << "the layer is gone";
}

TEST_F(PlaneOfTheBuilding, RefusesATargetOfAnotherSize) {
  const ReferenceScene made = scene();
  Renderer renderer = loaded(made);
  ASSERT_OK(renderer.upload(view_of(landscape(made.view.width, made.view.height))));
  Offscreen target = make_target(10, 10);
  EXPECT_THAT(renderer.draw_for_plane(made.measured, target.target()), FailsWith(HasSubstr("the object's box")));
}

}  // namespace
}  // namespace kasumi
