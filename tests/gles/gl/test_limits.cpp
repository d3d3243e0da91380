// The limits of a Raspberry Pi's GPU, and of GLES 2: which of them our shaders and textures come close to.
#include <gmock/gmock.h>

#include "gles/gl/gl.hpp"
#include "tests/gles/gl/lesser_gl.hpp"
#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

using testing::Contains;
using testing::HasSubstr;

class Limits : public GlesTest {
 protected:
  void SetUp() override {
    gl_.emplace(GlLimits{});
    GlesTest::SetUp();
    if (context_ && info().es_major != 2) GTEST_SKIP() << "the context does not obey";
  }
  std::optional<LesserGl> gl_;
};

// Every map, shadow, glass, ground, foreground, depth, lens, all sorts of air and of noise.
ReferenceScene with_everything() {
  ReferenceScene scene = box_scene();
  scene.model = box_model(60, 40, 60, 48);
  scene.model.textures = {soft_texture(32), soft_normals(16), soft_data(16), soft_texture(8)};
  ModelMaterial& material = scene.model.materials[0];
  material.metallic = 0.6f;
  material.roughness = 0.5f;
  material.reflectance = glm::vec3(0.04f);
  material.edge_reflectance = 1.0f;
  material.texture = 0;
  material.normal_map = {1, false};
  material.roughness_map = {2, false};
  material.occlusion_map = {2, true};
  material.emission = {0.1f, 0.05f, 0.2f};
  material.emission_map = {3, true};
  scene.model.materials.push_back(material);
  scene.model.materials.back().alpha = ModelMaterial::Alpha::blend;
  scene.model.parts.push_back(box_part({-25, 5, 35}, {35, 45, 45}, 4, 1));
  scene.model.ground = {box_part({-60, -1, -60}, {60, 0, 60}, 8)};
  scene.view.distortion = {-0.28, 0.11, 0.02, -0.015, -0.02};
  scene.appearance.shadows = true;
  Haze& haze = scene.appearance.haze;
  haze.fog_base_altitude_m = haze.observer_altitude_m - 20.0;
  haze.fog_scale_height_m = 15.0;
  haze.fog_per_m = 1e-4;
  scene.mask = Image<std::uint8_t>(160, 120, 255);
  scene.mask.at(3, 3) = 0;
  scene.depth_m = Image<float>(160, 120, 9000.0f);
  return scene;
}

TEST_F(Limits, OfShadersAreKept) {
  const ReferenceScene scene = with_everything();
  const auto camera = landscape(160, 120);
  const SensorNoise noise{glm::dvec3{0.0005}, glm::dvec3{0.003}, 5};
  for (const auto kind : {ResponseCurve::Kind::srgb, ResponseCurve::Kind::table}) {
    ReferenceScene made = scene;
    made.response.kind = kind;
    if (kind == ResponseCurve::Kind::table)
      for (auto& channel : made.response.light) channel = {0.0, 0.3, 1.0};
    Renderer renderer = make_renderer();
    ASSERT_OK(renderer.set_detail({1.2, 2, 2}));
    load(renderer, made);
    ASSERT_OK(renderer.upload(view_of(camera)));
    Offscreen target = make_target(160, 120);
    ASSERT_OK(renderer.draw(made.measured, target.target(), noise));
    const PixelBox box = renderer.object_box();
    Offscreen plane = make_target(box.right - box.left, box.bottom - box.top);
    ASSERT_OK(renderer.draw_for_plane(made.measured, plane.target(), noise));
    for (const auto detail : {HazeDetail::per_vertex, HazeDetail::per_fragment})
      ASSERT_OK(renderer.draw_moving(made.appearance, made.measured, target.target(), detail));
  }
  const GlUse& use = gl_use();
  EXPECT_GE(use.varying_vectors, 7) << "counted";
  EXPECT_LE(use.varying_vectors, 8) << use.most_varyings;
  EXPECT_GE(use.vertex_uniform_vectors, 70) << "counted";
  EXPECT_LE(use.vertex_uniform_vectors, 128) << use.most_vertex_uniforms;
  EXPECT_LE(use.fragment_uniform_vectors, 64);
  fmt::print("{} varying vectors, {} vertex and {} fragment uniform vectors\n", use.varying_vectors,
             use.vertex_uniform_vectors, use.fragment_uniform_vectors);
}

TEST_F(Limits, OfShadersRefuseWhatGoesBeyondThem) {
  std::string varyings, values, sum = "vec4(0.0)";
  for (int i = 0; i < 9; ++i) {
    varyings += fmt::format("varying vec4 v{};\n", i);
    values += fmt::format("v{} = p + {}.0;\n", i, i);
    sum += fmt::format(" + v{}", i);
  }
  const auto wide = link_program(
      "wide", "#version 100\nattribute vec4 p;\n" + varyings + "void main() {\n" + values + "gl_Position = p; }\n",
      "#version 100\nprecision highp float;\n" + varyings + "void main() { gl_FragColor = " + sum + "; }\n", {});
  ASSERT_FALSE(wide);
  EXPECT_THAT(wide.error().message, HasSubstr("9 varying vectors: this GPU has 8"));
  const auto full = link_program("full",
                                 "#version 100\nattribute vec4 p;\nuniform vec4 u[129];\nvoid main() { vec4 s = p; for "
                                 "(int i = 0; i < 129; ++i) s += u[i]; gl_Position = s; }\n",
                                 "#version 100\nvoid main() { gl_FragColor = vec4(1.0); }\n", {});
  ASSERT_FALSE(full);
  EXPECT_THAT(full.error().message, HasSubstr("129 vertex uniform vectors: this GPU has 128"));
}

TEST_F(Limits, OfTexturesHalveWhatIsLarger) {
  ReferenceScene scene = box_scene();
  ModelTexture texture = soft_texture(32);
  texture.pixels = Image<glm::u8vec4>(2100, 8, glm::u8vec4{120, 90, 60, 255});
  scene.model.textures.push_back(texture);
  scene.model.materials[0].texture = 0;
  scene.appearance.shadows = true;
  Renderer renderer = loaded(scene);
  EXPECT_THAT(renderer.notes(), Contains(HasSubstr("2100")));
  EXPECT_THAT(renderer.notes(), Contains(HasSubstr("8 bits"))) << "vc4 draws to no half floats";
  const auto camera = landscape(160, 120);
  ASSERT_OK(renderer.upload(view_of(camera)));
  Offscreen target = make_target(160, 120);
  ASSERT_OK(renderer.draw(scene.measured, target.target()));
  EXPECT_EQ(renderer.upload(view_of(Image<Rgb8>(2049, 8))).error().kind, FaultKind::bad_input);
  EXPECT_EQ(Offscreen::create(info(), 8, 2049).error().kind, FaultKind::bad_input);
}

}  // namespace
}  // namespace kasumi
