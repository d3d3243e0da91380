// What physics demands of the material, however it is approximated: energy is conserved, and a reflection equals the
// integral it stands for.
#include <cmath>
#include <random>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "gles/gl/surface_texture.hpp"
#include "gles/light/reflection_table.hpp"
#include "tests/gles/object/reference_shading.hpp"
#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

class MaterialRules : public GlesTest {
 protected:
  // A ball of this material in a white furnace, over a camera's picture of the furnace.
  void expect_unseen(const ModelMaterial& material, const std::string& what, const RendererOptions& options = {}) {
    ReferenceScene scene = box_scene();
    scene.model = {};
    scene.model.name = "ball";
    scene.model.materials.push_back(material);
    scene.model.parts.push_back(ball_part({0, 0, 0}, 25, 24));
    scene.model_to_world = model_to_world({0, 3500, 0, {}, 1.0});
    scene.appearance = furnace(0.7);
    scene.measured = furnace(0.7).horizon;
    scene.measured.light.fill(glm::dvec3{0.5});
    Renderer renderer = loaded(scene, options);
    const auto layer = renderer.read_layer();
    ASSERT_OK(layer);
    int covered = 0;
    const double step = options.force_rgba8 ? 2.5 : 1.0;  // 8 bits of a square root are coarser there, and dithered
    for (const glm::vec4& texel : layer->elements()) {
      if (texel.a < 1.0f) continue;
      ++covered;
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(texel[c], 1.0, step / 255.0) << what;
    }
    EXPECT_GT(covered, 5000);
    const Image<Rgb8> camera(160, 120, Rgb8{188, 188, 188});  // 0.5 encoded: 187.5
    const Image<Rgb8> picture = draw(renderer, scene.measured, view_of(camera));
    int worst = 0;
    for (const Rgb8& pixel : picture.elements())
      for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(int(pixel[c]) - 188));
    EXPECT_LE(worst, options.force_rgba8 ? 2 : 1) << what << ": steps of 255";
  }
};

TEST_F(MaterialRules, AWhiteMattBallIsInvisibleInAUniformSky) {
  expect_unseen({.name = "white"}, "matt");
  expect_unseen({.name = "white"}, "matt, 8 bits", {.force_rgba8 = true});
}

TEST_F(MaterialRules, WhiteMetalAndWhitePaintOfAnyRoughnessAreInvisibleInAUniformSky) {
  for (const double roughness : {0.0, 0.1, 0.25, 0.5, 0.75, 1.0})
    for (const float metallic : {0.0f, 0.5f, 1.0f})
      expect_unseen({.name = "white",
                     .metallic = metallic,
                     .roughness = float(roughness),
                     .reflectance = glm::vec3(0.04f),
                     .edge_reflectance = 1.0f},
                    fmt::format("roughness {}, metallic {}", roughness, metallic));
}

TEST_F(MaterialRules, GreyMetalLosesLightOnlyThroughItsColour) {
  // Seen head-on, a fully rough GGX metal reflects 1 - ln 2 of its colour f in one reflection, and reflections between
  // facets make a geometric series of it: f x / (1 - f (1 - x)). A polished one reflects f.
  for (const double roughness : {0.05, 1.0}) {
    const double once = roughness < 0.5 ? 1.0 : 1.0 - std::log(2.0);
    const double expected = 0.5 * once / (1.0 - 0.5 * (1.0 - once));
    ReferenceScene scene = box_scene();
    scene.model = {};
    scene.model.materials.push_back(
        {.name = "grey", .base_colour = {0.5f, 0.5f, 0.5f, 1.0f}, .metallic = 1.0f, .roughness = float(roughness)});
    scene.model.parts.push_back(ball_part({0, 0, 0}, 25, 24));
    scene.model_to_world = model_to_world({0, 3500, 0, {}, 1.0});
    scene.appearance = furnace(1.0);
    Renderer renderer = loaded(scene);
    const auto layer = renderer.read_layer();
    ASSERT_OK(layer);
    for (const glm::vec4& texel : layer->elements()) {
      if (texel.a < 1.0f) continue;
      ASSERT_LE(texel.r, 1.0f + 1.0f / 255.0f);
    }
    const glm::vec4 middle = layer->at(layer->width() / 2, layer->height() / 2);
    EXPECT_NEAR(middle.r, expected, 0.02) << "seen head-on, roughness " << roughness;
  }
}

TEST(ReflectionIntegrals, AgreeWithAFinerIntegralOfTheBrdf) {
  std::mt19937_64 random(4);
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random() >> 11) * 0x1p-53;
  };
  for (int i = 0; i < 40; ++i) {
    const double across = between(0.05, 1.0), roughness = between(0.1, 1.0);
    const DirectionalAlbedo quick = directional_albedo(across, roughness);
    const ReferenceGivenBack fine = reference_given_back(across, roughness);
    EXPECT_NEAR(quick.all, fine.head_on + fine.edge, 0.01) << across << ", " << roughness;
    EXPECT_NEAR(quick.edge, fine.edge, 0.01) << across << ", " << roughness;
    EXPECT_NEAR(quick.along, fine.mean_along, 0.02) << across << ", " << roughness;
    EXPECT_NEAR(quick.aside, fine.mean_aside, 0.02) << across << ", " << roughness;
  }
}

TEST(ReflectionIntegrals, MatchTheirKnownLimits) {
  for (const double across : {0.2, 0.7, 1.0}) {  // a smooth mirror: all of it, with Schlick's own edge
    EXPECT_NEAR(directional_albedo(across, 0.0).all, 1.0, 1e-3);
    EXPECT_NEAR(directional_albedo(across, 0.0).edge, std::pow(1.0 - across, 5), 1e-3);
  }
  EXPECT_NEAR(directional_albedo(1.0, 1.0).all, 1.0 - std::log(2.0), 5e-3);
  EXPECT_NEAR(mean_cosine(0.0), 1.0, 1e-4);
  EXPECT_NEAR(mean_cosine(1.0), 2.0 / 3.0, 1e-4);  // fully rough: Lambert's
  for (const double across : {0.2, 0.7, 0.95}) {   // a smooth mirror shows its mirror image, sharply
    const ReflectionLookup seen = reflection_lookup(across, directional_albedo(across, 0.0));
    EXPECT_NEAR(seen.lean, 1.0, 1e-3);
    EXPECT_NEAR(seen.roughness, 0.0, 1e-2);
  }
  for (const double across : {0.1, 0.5, 0.9})  // the lookup is along the lobe's mean direction
    for (const double roughness : {0.2, 0.5, 0.8}) {
      const DirectionalAlbedo back = directional_albedo(across, roughness);
      const ReflectionLookup seen = reflection_lookup(across, back);
      const glm::dvec2 mean{back.aside, back.along}, mirror{std::sqrt(1.0 - across * across), across};
      const glm::dvec2 image = glm::normalize(glm::mix(glm::dvec2{0, 1}, mirror, seen.lean));
      EXPECT_NEAR(mean_cosine(seen.roughness), std::max(glm::length(mean), 2.0 / 3.0), 3e-3);  // no lobe is wider
      EXPECT_NEAR(glm::dot(image, glm::normalize(mean)), 1.0, 1e-3);
    }
}

// The whole hemisphere, 1 degree by 3: the reflection that the split sum approximates.
glm::dvec3 integrated_reflection(const ReferenceSky& sky, const glm::dvec3& n, const glm::dvec3& eye,
                                 double roughness) {
  const glm::dvec3 x = glm::normalize(glm::cross(n, std::abs(n.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0)));
  const glm::dvec3 y = glm::cross(n, x);
  constexpr int kRings = 180, kTurns = 240;
  glm::dvec3 sum{0.0};
  for (int i = 0; i < kRings; ++i)
    for (int j = 0; j < kTurns; ++j) {
      const double tilt = 0.5 * kPi * (i + 0.5) / kRings, turn = 2.0 * kPi * (j + 0.5) / kTurns;
      const double nl = std::cos(tilt);
      const glm::dvec3 l = nl * n + std::sin(tilt) * (std::cos(turn) * x + std::sin(turn) * y);
      const glm::dvec3 h = glm::normalize(l + eye);
      const double solid_angle = std::sin(tilt) * (0.5 * kPi / kRings) * (2.0 * kPi / kTurns);
      sum += microfacet_brdf(glm::dot(n, h), nl, glm::dot(n, eye), roughness) * nl * solid_angle *
             reference_sky_radiance(sky, l);
    }
  return sum;
}

TEST(Reflection, OfTheSkyIsCloseToItsIntegral) {
  // The reflected sky is an integral over the lobe, which the split sum replaces by two factors.
  const ObjectLight light = afternoon(view_north(160, 120, 6000)).light;
  ObjectLight without_sun = light;
  without_sun.sun_irradiance = glm::dvec3{0.0};
  const ReferenceSky sky = reference_sky(light);
  ModelMaterial mirror;
  mirror.metallic = 1.0f;
  double worst = 0.0;
  for (const double roughness : {0.35, 0.5, 0.7, 1.0})
    for (const glm::dvec3& n :
         {glm::dvec3{0, 0, 1}, glm::normalize(glm::dvec3{0.3, -0.8, 0.4}), glm::normalize(glm::dvec3{-0.7, -0.6, 0.0}),
          glm::normalize(glm::dvec3{0.1, -0.5, 0.9})}) {
      const glm::dvec3 eye = glm::normalize(glm::dvec3{0.05, -1.0, 0.25});
      ReferenceSurface surface{.normal = n, .metallic = 1.0, .roughness = roughness};
      mirror.roughness = float(roughness);
      const glm::dvec3 shown = reference_radiance(mirror, surface, without_sun, sky, eye);
      const glm::dvec3 once = integrated_reflection(sky, n, eye, roughness);
      // What a single reflection loses comes back diffusely (white metal).
      const ReferenceGivenBack back = reference_given_back(glm::dot(n, eye), roughness);
      const glm::dvec3 whole = once + (1.0 - back.head_on - back.edge) * reference_sky_irradiance(sky, n) / kPi;
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(shown[c] / whole[c], 1.0, 0.06) << "roughness " << roughness << ", n.z " << n.z;
        worst = std::max(worst, std::abs(shown[c] / whole[c] - 1.0));
      }
    }
  testing::Test::RecordProperty("worst", fmt::format("{:.3f}", worst));
}

TEST_F(MaterialRules, LeavesStayVisibleAtADistance) {
  // Leaves of many sizes, cut out of a texture: where texels are no longer resolved, coverage is the same as close up.
  // Plain averages would fall below the cutoff and leave nothing.
  std::mt19937_64 random(7);
  ModelTexture leaves;
  leaves.pixels = Image<glm::u8vec4>(128, 128, glm::u8vec4{60, 90, 40, 0});
  for (int leaf = 0; leaf < 110; ++leaf) {
    const int cx = static_cast<int>(random() % 128), cy = static_cast<int>(random() % 128);
    const int r = 2 + static_cast<int>(random() % 6);
    for (int y = -r; y <= r; ++y)
      for (int x = -r; x <= r; ++x)
        if (x * x + y * y <= r * r) leaves.pixels.at((cx + x + 128) % 128, (cy + y + 128) % 128).a = 255;
  }
  for (const float cutoff : {0.5f, 0.3f}) {
    ReferenceScene scene = box_scene();
    scene.model = {};
    scene.model.textures.push_back(leaves);
    scene.model.materials.push_back(
        {.name = "leaves", .texture = 0, .alpha = ModelMaterial::Alpha::mask, .alpha_cutoff = cutoff});
    scene.model.parts.push_back(box_part({-40, 0, 0}, {40, 40, 1}, 1));
    scene.model.parts[0].indices.resize(6);
    scene.model_to_world = model_to_world({0, 3500, -20, {}, 1.0});
    const double share = share_above(leaves.pixels, double(cutoff));
    for (const float repeats : {1.0f, 8.0f, 40.0f}) {
      ReferenceScene there = scene;
      for (ModelVertex& vertex : there.model.parts[0].vertices) vertex.texture *= repeats;
      Renderer renderer = loaded(there);
      const auto layer = renderer.read_layer();
      ASSERT_OK(layer);
      double sum = 0.0, count = 0.0;
      for (int y = 4; y < layer->height() - 4; ++y)
        for (int x = 4; x < layer->width() - 4; ++x) sum += double(layer->at(x, y).a), count += 1.0;
      RecordProperty(fmt::format("covered_{}_{}", cutoff, repeats),
                     fmt::format("{:.3f} of {:.3f}", sum / count, share));
      EXPECT_NEAR(sum / count, share, 0.12) << "cutoff " << cutoff << ", repeated " << repeats << " times";
    }
  }
}

TEST_F(MaterialRules, AFlatRoofKeepsItsStripes) {
  if (info().software || !info().has("GL_EXT_texture_filter_anisotropic"))
    GTEST_SKIP() << info().renderer << " filters isotropically only";
  // Stripes that run away from the camera on ground seen at 5 degrees. Isotropic filtering would make them a uniform
  // grey.
  ReferenceScene scene = box_scene();
  scene.model = {};
  ModelTexture stripes;
  stripes.pixels = Image<glm::u8vec4>(64, 64);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      stripes.pixels.at(x, y) = x % 8 < 4 ? glm::u8vec4{40, 40, 40, 255} : glm::u8vec4{220, 220, 220, 255};
  scene.model.textures.push_back(stripes);
  scene.model.materials.push_back({.name = "roof", .texture = 0});
  scene.model.parts.push_back(box_part({-40, -1, -400}, {40, 0, 400}, 1));
  scene.model.parts[0].indices = {scene.model.parts[0].indices.begin() + 24, scene.model.parts[0].indices.begin() + 30};
  for (ModelVertex& vertex : scene.model.parts[0].vertices) vertex.texture *= glm::vec2(2.0f, 20.0f);
  scene.model_to_world = model_to_world({0, 3500, -306, {}, 1.0});
  const double pitch = -std::atan2(306.0, 3500.0);
  scene.view.world_to_camera = glm::dmat4({1, 0, 0, 0}, {0, std::sin(pitch), std::cos(pitch), 0},
                                          {0, -std::cos(pitch), std::sin(pitch), 0}, {0, 0, 0, 1});
  const Image<Rgb8> camera = landscape(160, 120);
  Renderer renderer = loaded(scene);
  expect_like(draw(renderer, scene.measured, view_of(camera)), render_reference(scene, camera, turned_lattice()), 34.0);
}

}  // namespace
}  // namespace kasumi
