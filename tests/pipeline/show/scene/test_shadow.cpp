// The shadow on the ground against the sun's ephemeris.
#include <cmath>

#include <gtest/gtest.h>

#include "estimator/sky/sun.hpp"
#include "gles/composite/renderer.hpp"

namespace kasumi {
namespace {

// A cube of `side_m` around a place above the model's origin, and level ground.
Model lantern(float up_m, float side_m) {
  Model model;
  model.materials = {{.name = "lantern"}, {.name = "ground"}};
  ModelPart cube;
  for (int corner = 0; corner < 8; ++corner)
    cube.vertices.push_back(
        {.position = 0.5f * side_m * glm::vec3{corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1} +
                     glm::vec3{0, up_m, 0}});
  cube.indices = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                  2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  model.parts = {cube};
  ModelPart ground;
  ground.material = 1;
  for (const auto& [x, z] : {std::pair{-200.0f, 200.0f}, {200.0f, 200.0f}, {200.0f, -200.0f}, {-200.0f, -200.0f}})
    ground.vertices.push_back({.position = {x, 0, z}});
  ground.indices = {0, 1, 2, 0, 2, 3};
  model.ground = {ground};
  return model;
}

TEST(ShadowOnTheGround, LiesWhereTheEphemerisSaysAtFourTimesOfADay) {
  auto context = open_headless_context();
  if (!context) GTEST_SKIP() << context.error().message;
  Renderer renderer = Renderer::create(**context).value();
  constexpr double kHeight_m = 1000.0, kPixel_m = 0.25, kLantern_m = 20.0;
  // Seen from straight above, north upwards.
  SceneView view{
      .width = 640, .height = 640, .focal_px = glm::dvec2{kHeight_m / kPixel_m}, .centre_px = {319.5, 319.5}};
  view.world_to_camera = glm::dmat4{{1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, -1, 0}, {0, 0, 0, 1}};
  ASSERT_TRUE(renderer.set_model(lantern(kLantern_m, 2.0f)));
  ASSERT_TRUE(renderer.set_view(view, model_to_world({.up_m = -kHeight_m, .heading = from_degrees(24.0)})));

  ObjectAppearance look;
  look.aerial_perspective = false;
  look.shadows = true;
  look.light.sun_irradiance = glm::dvec3{2.0};
  look.light.around = light_around_of([](const Direction&) { return glm::dvec3{0.09}; });
  look.horizon.last_px = {639.0, 639.0};
  look.horizon.light.fill(glm::dvec3{1.0});

  const Site kii{"Kii", 34.1, 135.9, 980.0};
  const auto day = std::chrono::sys_days{std::chrono::year{2026} / 10 / 20};
  using std::chrono::minutes;
  for (const auto time : {minutes{-60}, minutes{75}, minutes{180}, minutes{6 * 60 + 20}}) {  // 8:00 to 15:20 there
    const SunPosition sun = sun_position(day + time, kii);
    const double elevation_deg = 90.0 - to_degrees(sun.zenith);
    SCOPED_TRACE(fmt::format("sun {:.2f} deg high at azimuth {:.2f}", elevation_deg, to_degrees(sun.azimuth)));
    look.light.sun_direction = sun.direction;
    ASSERT_TRUE(renderer.redraw_layer(look));
    const auto layer = renderer.read_layer();
    ASSERT_TRUE(layer) << layer.error().message;
    const PixelBox box = renderer.object_box();
    double weight = 0.0;
    glm::dvec2 place{0.0};
    for (int y = 0; y < layer->height(); ++y)
      for (int x = 0; x < layer->width(); ++x) {
        const glm::dvec2 metres = kPixel_m * glm::dvec2{box.left + x - 319.5, 319.5 - box.top - y};
        if (glm::length(metres) < 4.0) continue;  // the lantern itself
        weight += double(layer->at(x, y).a);
        place += double(layer->at(x, y).a) * metres;
      }
    place /= weight;
    const double length_m = glm::length(place), expected_m = kLantern_m * std::tan(sun.zenith.value);
    const double azimuth_deg = std::fmod(to_degrees(Radians{std::atan2(-place.x, -place.y)}) + 360.0, 360.0);
    fmt::print("sun {:.2f} deg high at azimuth {:.2f}: shadow {:.2f} m (height / tan: {:.2f} m), from {:.2f} deg\n",
               elevation_deg, to_degrees(sun.azimuth), length_m, expected_m, azimuth_deg);
    EXPECT_NEAR(length_m / expected_m, 1.0, 0.003);
    EXPECT_NEAR(azimuth_deg, to_degrees(sun.azimuth), 0.2) << "degrees";
  }
}

}  // namespace
}  // namespace kasumi
