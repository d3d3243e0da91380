// The ground's own light in the layer: what a shadow takes where the sun does not reach, and what the object hides of the
// sky. Against the closed form; the layer's alpha is what is taken of green.
#include <cmath>

#include <glm/geometric.hpp>

#include "tests/gles/object/reference_shading.hpp"
#include "tests/gles/scenes.hpp"

namespace kasumi {
namespace {

class GroundLightInTheLayer : public GlesTest {
 protected:
  // A slab above level ground, seen from above; its shadow's core is many pixels wide.
  static ReferenceScene slab_scene() {
    ReferenceScene scene;
    scene.view = view_north(128, 96, 300);
    scene.view.world_to_camera = glm::dmat4{{1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, -1, 0}, {0, 0, 0, 1}};  // straight down
    scene.view.near_m = 50.0;
    scene.model.materials = {{.name = "slab"}, {.name = "ground", .base_colour = {0.2f, 0.2f, 0.2f, 1.0f}}};
    scene.model.parts = {box_part({-30, 20, -30}, {30, 21, 30}, 1)};
    ModelPart ground = box_part({-90, -1, -90}, {90, 0, 90}, 1, 1);
    ground.indices = {ground.indices.begin() + 24, ground.indices.begin() + 30};  // the face that looks up
    scene.model.ground = {ground};
    scene.model_to_world = model_to_world({0, 0, -400, from_degrees(25), 1.0});
    scene.appearance = afternoon(scene.view);
    scene.appearance.shadows = true;
    const double up = from_degrees(30.0).value;
    scene.appearance.light.sun_direction = {-std::cos(up), 0.0, std::sin(up)};  // the shadow lies to the east
    scene.measured = measured_airlight(scene.view);
    return scene;
  }
  static double sun_of(const ObjectAppearance& look) {
    return look.light.sun_irradiance.g * look.light.sun_direction.z;
  }
  static double sky_of(const ObjectAppearance& look) { return irradiance(look.light.around, {0, 0, 1}).g; }

  struct Seen {
    Image<glm::vec4> layer;
    PixelBox box;
    double at(int x, int y) const { return static_cast<double>(layer.at(x - box.left, y - box.top).a); }
  };
  Seen layer_of(const ReferenceScene& scene, const RendererOptions& options = {}) {
    Renderer renderer = loaded(scene, options);
    return {renderer.read_layer().value(), renderer.object_box()};
  }
  // In the shadow beside the slab: 20 m / tan 30 deg = 35 m to the east of it, .75 pixels a metre; and in the sun.
  static constexpr int kInShadow_x = 64 + 36, kInSun_x = 64 - 36, kRow = 48;
};

TEST_F(GroundLightInTheLayer, OnlyTheSunThatIsThereIsTaken) {
  ReferenceScene scene = slab_scene();
  const double sun = sun_of(scene.appearance), sky = sky_of(scene.appearance);
  for (const bool rgba8 : {false, true})
    for (const float share : {1.0f, 0.5f, 0.2f, 0.0f}) {
      auto sunlight = std::make_shared<GroundSunlight>();
      sunlight->share = Image<float>(3, 2, share);
      sunlight->step_px = 50.0;
      scene.appearance.ground_sunlight = sunlight;
      const double expected = double(share) * sun / (double(share) * sun + sky);
      const double taken = layer_of(scene, {.force_rgba8 = rgba8}).at(kInShadow_x, kRow);
      fmt::print("sunlit {:.1f}: {:.4f} of the light is taken, expected {:.4f}\n", double(share), taken, expected);
      EXPECT_NEAR(taken, expected, 0.006);
      EXPECT_LE(layer_of(scene).at(kInSun_x, kRow), 0.001);
    }
  scene.appearance.ground_sunlight = nullptr;
  EXPECT_NEAR(layer_of(scene).at(kInShadow_x, kRow), sun / (sun + sky), 0.006);
}

// A real shadow's edge across the object's: half way between two points of the map, at the pixel where they are equal.
TEST_F(GroundLightInTheLayer, LiesWhereThePictureShowsIt) {
  ReferenceScene scene = slab_scene();
  const double sun = sun_of(scene.appearance), sky = sky_of(scene.appearance);
  auto sunlight = std::make_shared<GroundSunlight>();
  sunlight->share = Image<float>(5, 12, 1.0f);
  sunlight->first_px = {30.0, 4.0};
  sunlight->step_px = 8.0;
  for (int x = 0; x < 5; ++x)
    for (int y = 6; y < 12; ++y) sunlight->share.at(x, y) = 0.0f;  // from row 52 on; row 44 is lit
  scene.appearance.ground_sunlight = sunlight;
  const Seen seen = layer_of(scene);
  for (const int y : {40, 45, 46, 48, 50, 51, 56}) {
    const double share = std::clamp((52.0 - y) / 8.0, 0.0, 1.0);
    EXPECT_NEAR(seen.at(kInShadow_x, y), share * sun / (share * sun + sky), 0.008) << "row " << y;
  }
}

TEST_F(GroundLightInTheLayer, TheSkyThatTheObjectHidesIsTakenAlsoWithoutASun) {
  for (const bool sunny : {true, false}) {
    ReferenceScene scene = slab_scene();
    if (!sunny) scene.appearance.light.sun_irradiance = glm::dvec3{0.0};
    const double sun = sun_of(scene.appearance), sky = sky_of(scene.appearance);
    auto foot = std::make_shared<FootShade>();
    foot->first_m = {-60.0, -60.0};
    foot->step_m = {30.0, 30.0};
    foot->sky_seen = Image<float>(5, 5, 1.0f);
    for (int y = 0; y < 5; ++y)
      for (int x = 0; x < 5; ++x) foot->sky_seen.at(x, y) = 0.4f + 0.15f * static_cast<float>(x);  // .4 west, 1 east
    scene.appearance.foot_shade = foot;
    const Seen seen = layer_of(scene);
    for (const int x : {kInSun_x, kInShadow_x}) {
      const double east_m = (x - 63.5) / 300.0 * 400.0;
      const double hidden = 0.6 - 0.15 * (east_m + 60.0) / 30.0;
      const double shadow = sunny && x == kInShadow_x ? sun : 0.0;
      const double expected = (shadow + hidden * sky) / (sun + sky);
      fmt::print("{}, {:+.0f} m: {:.4f} of the light is taken, expected {:.4f}\n", sunny ? "sun" : "no sun", east_m,
                 seen.at(x, kRow), expected);
      EXPECT_NEAR(seen.at(x, kRow), expected, 0.006);
    }
  }
}

}  // namespace
}  // namespace kasumi
