// Fragment shaders in 16 bits. GLES 2 lets a driver compute everything that is not declared highp in half floats, and
// samplers are low precision unless they say otherwise; llvmpipe does so where the processor converts them (F16C).
#include <cmath>

#include "gles/gl/gl.hpp"
#include "gles/gl/program.hpp"
#include "gles/picture/flat_picture.hpp"
#include "tests/gles/gl/halves.hpp"
#include "tests/gles/gl/lesser_gl.hpp"
#include "tests/gles/picture/all_layouts.hpp"
#include "tests/gles/scenes.hpp"
#include "tests/picture_difference.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::Contains;
using testing::HasSubstr;
using Pictures = std::vector<std::pair<std::string, Image<Rgb8>>>;

class Precision : public GlesTest {
 protected:
  void SetUp() override {
    GlesTest::SetUp();
    if (context_ && !computes_in_halves()) GTEST_SKIP() << info().renderer << " computes mediump in 32 bits";
  }

  // The same pictures by a new context.
  Pictures drawn_in(FragmentPrecision precision, const std::function<void(Pictures&)>& draw_all) {
    const LesserGl gl(precision);
    auto context = open_headless_context();
    if (!context) throw std::runtime_error(context.error().message);
    context_ = std::move(*context);
    Pictures pictures;
    draw_all(pictures);
    return pictures;
  }

  // Each picture within `as_written` and `all_in_16` steps of 255 of the same in 32 bits.
  void expect_alike(const std::function<void(Pictures&)>& draw_all, int all_in_16 = 2, int as_written = 2) {
    const Pictures exact = drawn_in(FragmentPrecision::high, draw_all);
    for (const bool medium : {false, true}) {
      const Pictures pictures = drawn_in(medium ? FragmentPrecision::medium : FragmentPrecision::driver, draw_all);
      ASSERT_EQ(pictures.size(), exact.size());
      for (std::size_t i = 0; i < exact.size(); ++i) {
        const auto& [name, picture] = pictures[i];
        const int off = difference(picture, exact[i].second).largest, most = medium ? all_in_16 : as_written;
        fmt::print("{}, {}: {} of 255\n", name, medium ? "all in 16 bits" : "as written", off);
        EXPECT_LE(off, most) << name << (medium ? ", all in 16 bits" : ", as written");
        if (off <= most) continue;
        save_png(exact[i].second, test_output_folder() / "precision" / (name + "-exact.png"));
        save_png(picture, test_output_folder() / "precision" / (name + (medium ? "-16.png" : "-written.png")));
      }
    }
  }

  void add(Pictures& pictures, const std::string& name, const ReferenceScene& scene,
           const RendererOptions& options = {}, const ObjectDetail& detail = {}, const SensorNoise& noise = {},
           const JpegSteps* jpeg = nullptr) {
    Renderer renderer = make_renderer(options);
    ASSERT_OK(renderer.set_detail(detail));
    load(renderer, scene);
    ASSERT_OK(renderer.upload(view_of(camera_), jpeg ? std::make_shared<const JpegSteps>(*jpeg) : nullptr));
    Offscreen target = make_target(camera_.width(), camera_.height());
    ASSERT_OK(renderer.draw(scene.measured, target.target(), noise));
    pictures.emplace_back(name, *target.read());
  }

  const Image<Rgb8> camera_ = landscape(1920, 1080);
};

// Full HD, with the object where coordinates are largest.
ReferenceScene far_corner(ReferenceScene scene) {
  scene.view.width = 1920;
  scene.view.height = 1080;
  scene.view.centre_px = {1920 - 81.0, 1080 - 61.0};
  scene.appearance.horizon.first_px = {1000, 500};
  scene.appearance.horizon.last_px = {1900, 1000};
  scene.measured.first_px = {1000, 500};
  scene.measured.last_px = {1900, 1000};
  return scene;
}
ReferenceScene dressed_boxes() {
  ReferenceScene scene = far_corner(box_scene());
  scene.model.textures = {soft_texture(32), soft_normals(16), soft_data(16), soft_texture(8)};
  ModelMaterial& material = scene.model.materials[0];
  material.base_colour = {0.9f, 0.8f, 0.7f, 1.0f};
  material.metallic = 0.6f;
  material.roughness = 0.5f;
  material.reflectance = glm::vec3(0.04f);
  material.edge_reflectance = 1.0f;
  material.texture = 0;
  material.normal_map = {1, false};
  material.normal_scale = 0.8f;
  material.roughness_map = {2, false};
  material.occlusion_map = {2, true};
  material.occlusion_strength = 0.7f;
  material.emission = {0.1f, 0.05f, 0.2f};
  material.emission_map = {3, true};
  return scene;
}

ReferenceScene with_table(ReferenceScene scene) {
  scene.response.kind = ResponseCurve::Kind::table;
  for (auto& channel : scene.response.light)
    for (int i = 0; i < 256; ++i) channel.push_back(std::pow(i / 255.0, 1.9));
  return scene;
}
ReferenceScene with_foreground(ReferenceScene scene) {
  scene.mask = Image<std::uint8_t>(1920, 1080, 255);
  for (int y = 0; y < 1080; ++y)
    for (int x = 0; x < 1920; ++x) scene.mask.at(x, y) = static_cast<std::uint8_t>(std::clamp((x - 1820) * 12, 0, 255));
  return scene;
}

TEST_F(Precision, OfTheLayerAndItsComposite) {
  expect_alike([&](Pictures& pictures) {
    const ReferenceScene plain = far_corner(box_scene());
    add(pictures, "plain", plain);
    add(pictures, "noise", plain, {}, {}, {glm::dvec3{0.0005}, glm::dvec3{0.003}, 5});
    add(pictures, "point spread", plain, {}, {1.2, 2, 2});
    ReferenceScene mixed = with_foreground(plain);  // by the mask, which is sure of no pixel behind
    for (auto& share : mixed.mask.elements()) share = std::min<std::uint8_t>(share, 254);
    add(pictures, "foreground", mixed);
    ReferenceScene linear = plain;
    linear.response.kind = ResponseCurve::Kind::linear;
    add(pictures, "linear response", linear);
    add(pictures, "response table", with_table(plain));
  });
}

// Sharpening enlarges what 16 bits have left of the composite, and a step of the composite may turn a coefficient by one
// of its own steps. Without high precision blocks are left out.
TEST_F(Precision, OfTheCamerasProcessing) {
  expect_alike(
      [&](Pictures& pictures) {
        add(pictures, "sharpened", far_corner(box_scene()), {}, {.point_spread_px = 0.6, .sharpening = 0.9});
      },
      5);
  JpegSteps steps;
  for (std::size_t i = 0; i < steps.luma.size(); ++i) steps.luma[i] = steps.chroma[i] = 2;
  const auto draw_all = [&](Pictures& pictures) {
    add(pictures, "sharpened, in blocks", far_corner(box_scene()), {},
        {.point_spread_px = 0.6, .sharpening = 0.9, .jpeg_blocks = true}, {}, &steps);
  };
  const int off = difference(drawn_in(FragmentPrecision::driver, draw_all)[0].second,
                             drawn_in(FragmentPrecision::high, draw_all)[0].second)
                      .largest;
  fmt::print("sharpened, in blocks, as written: {} of 255\n", off);
  EXPECT_LE(off, 8) << "coefficients of one block that turn by 2 each";
}

// Without high precision it is mixed by the mask, not solved.
TEST_F(Precision, OfAForegroundThatIsSolved) {
  expect_alike(
      [&](Pictures& pictures) { add(pictures, "solved foreground", with_foreground(far_corner(box_scene()))); }, 255);
}

// Two dithers, of the layer and of the picture, and the coarser one that 16 bits leave of the first.
TEST_F(Precision, OfALayerInBytes) {
  expect_alike(
      [&](Pictures& pictures) {
        const ReferenceScene plain = far_corner(box_scene());
        add(pictures, "layer in bytes", plain, {.force_rgba8 = true});
        add(pictures, "point spread in bytes", plain, {.force_rgba8 = true}, {1.2, 2, 2});
      },
      3);
}

// The normal's 11 bits shift a glint's edge.
TEST_F(Precision, OfAllMapsOfAMaterial) {
  expect_alike(
      [&](Pictures& pictures) {
        add(pictures, "material", dressed_boxes());
        add(pictures, "material, decoded in the shader", dressed_boxes(), {.force_encoded_textures = true});
      },
      8);
}

TEST_F(Precision, OfShadowsAndDepths) {
  const auto draw_all = [&](Pictures& pictures) {
    ReferenceScene scene = far_corner(box_scene());
    scene.model.ground = {box_part({-200, -1, -200}, {200, 0, 200}, 8)};
    scene.appearance.shadows = true;
    add(pictures, "shadows", scene);
    add(pictures, "packed shadows", scene, {.force_packed_shadows = true, .force_smooth_shadows = true});
    scene.appearance.shadows = false;
    scene.depth_m = Image<float>(1920, 1080);
    for (int y = 0; y < 1080; ++y)
      for (int x = 0; x < 1920; ++x) scene.depth_m.at(x, y) = 3400.0f + 0.5f * static_cast<float>(y - 900);
    add(pictures, "depth", scene);
  };
  const Pictures exact = drawn_in(FragmentPrecision::high, draw_all);
  const Pictures written = drawn_in(FragmentPrecision::driver, draw_all);
  for (std::size_t i = 0; i < exact.size(); ++i)
    EXPECT_LE(difference(written[i].second, exact[i].second).largest, 2) << exact[i].first;
  // They need 24 bits: without them they are left out, and that is said.
  const LesserGl gl(FragmentPrecision::medium);
  context_ = std::move(*open_headless_context());
  Renderer renderer = make_renderer();
  EXPECT_THAT(renderer.notes(), Contains(HasSubstr("no shadows: ")));
  ASSERT_OK(renderer.set_scene_depth(Image<float>(8, 8, 100.0f)));
  EXPECT_THAT(renderer.notes(), Contains(HasSubstr("the depth map is not used: ")));
}

TEST_F(Precision, OfWhatADisplayLaysOverThePicture) {
  expect_alike([&](Pictures& pictures) {
    for (const bool table : {false, true}) {
      const ReferenceScene scene = table ? with_table(far_corner(box_scene())) : far_corner(box_scene());
      Renderer renderer = loaded(scene);
      ASSERT_OK(renderer.upload(view_of(camera_)));
      const PixelBox box = renderer.object_box();
      Offscreen target = make_target(box.right - box.left, box.bottom - box.top);
      ASSERT_OK(renderer.draw_for_plane(scene.measured, target.target()));
      pictures.emplace_back(table ? "plane, response table" : "plane", *target.read());
    }
  });
}

TEST_F(Precision, OfAMovingView) {
  const auto draw_moving_views = [&](Pictures& pictures, const std::string& name, const ReferenceScene& scene) {
    for (const auto detail : {HazeDetail::per_vertex, HazeDetail::per_fragment}) {
      Renderer renderer = loaded(scene);
      pictures.emplace_back(name + (detail == HazeDetail::per_vertex ? ", by vertex" : ", by fragment"),
                            draw_moving(renderer, scene, view_of(camera_), detail));
    }
  };
  expect_alike([&](Pictures& p) { draw_moving_views(p, "moving", far_corner(box_scene())); });
  expect_alike([&](Pictures& p) { draw_moving_views(p, "moving, material", dressed_boxes()); }, 12);
  const auto behind_foreground = [&](Pictures& p) {
    draw_moving_views(p, "moving, foreground", with_foreground(far_corner(box_scene())));
  };
  expect_alike(behind_foreground, 14);  // gl_FragCoord has 16 bits there: its soft edge of 21 pixels is off by one
}

TEST_F(Precision, OfTheCamerasPictureInEveryLayout) {
  std::vector<std::uint8_t> bytes(std::size_t{1920} * 16 * 4);
  unsigned random = 7;
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>((random = random * 1664525u + 1013904223u) >> 24);
  expect_alike([&](Pictures& pictures) {
    Renderer renderer = make_renderer();
    for (const PixelLayout layout : kLayouts) {
      PictureView view{layout, YuvEncoding::bt709_limited, 1920, 16, {}};
      for (int i = 0; i < plane_count(layout); ++i)
        view.planes[static_cast<std::size_t>(i)] = {bytes.data(), plane_size(layout, 1920, 16, i).row_bytes};
      pictures.emplace_back(std::string(name_of(layout)),
                            draw(renderer, measured_airlight(view_north(1920, 16, 100)), view));
    }
  });
}

TEST_F(Precision, OfFlatPictures) {
  expect_alike([&](Pictures& pictures) {
    Image<Rgba8> picture(700, 300);
    for (int y = 0; y < 300; ++y)
      for (int x = 0; x < 700; ++x)
        picture.at(x, y) = {static_cast<std::uint8_t>(x), static_cast<std::uint8_t>(7 * y), 90,
                            static_cast<std::uint8_t>(x + y)};
    auto flat = FlatPicture::create(*context_, picture);
    ASSERT_OK(flat);
    Offscreen target = make_target(1920, 1080);
    clear_to(target.target(), glm::vec3(0.2f, 0.4f, 0.8f));
    ASSERT_OK(flat->draw(target.target(), {1200, 700, 700, 300}, 0.7));
    pictures.emplace_back("caption", *target.read());
  });
}

}  // namespace
}  // namespace kasumi
