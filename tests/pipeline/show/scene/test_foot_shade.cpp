// The sky that a building hides from the ground at its foot, against closed forms.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/units.hpp"
#include "pipeline/show/scene/foot_shade.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

constexpr float kGround_m = 200.0f;

void add_quad(ModelPart& part, const glm::vec3& corner, const glm::vec3& along, const glm::vec3& up) {
  const auto first = static_cast<std::uint32_t>(part.vertices.size());
  for (const glm::vec3& at : {corner, corner + along, corner + along + up, corner + up})
    part.vertices.push_back({.position = at});
  for (const std::uint32_t i : {0U, 1U, 2U, 0U, 2U, 3U}) part.indices.push_back(first + i);
}

// glTF's axes, which the placement at heading 0 turns to east, up, south.
Model with_ground(const ModelPart& part) {
  Model model;
  model.materials = {{.name = "wall"}, {.name = "ground"}};
  model.parts = {part};
  ModelPart ground;
  ground.material = 1;
  add_quad(ground, {-kGround_m, 0, kGround_m}, {2 * kGround_m, 0, 0}, {0, 0, -2 * kGround_m});
  model.ground = {ground};
  return model;
}

LightAround even_sky() {
  return light_around_of([](const Direction&) { return glm::dvec3{1.0}; });
}

double seen_at(const FootShade& shade, double east_m, double north_m) {
  const glm::dvec2 at = (glm::dvec2(east_m, north_m) - shade.first_m) / shade.step_m;
  const int x = static_cast<int>(std::floor(at.x)), y = static_cast<int>(std::floor(at.y));
  const double u = at.x - x, v = at.y - y;
  const auto texel = [&](int i, int j) { return static_cast<double>(shade.sky_seen.at(i, j)); };
  return std::lerp(std::lerp(texel(x, y), texel(x + 1, y), u), std::lerp(texel(x, y + 1), texel(x + 1, y + 1), u), v);
}

// The configuration factor of a horizontal element and a wall of width 2 w that stands at distance d across it, height h:
// Siegel and Howell's C-4, the element's normal parallel to the wall, for each half.
double hidden_by_wall(double w, double h, double d) {
  const double a = h / d, b = w / d;
  const auto half = (std::atan(b) - std::atan(b / std::sqrt(1.0 + a * a)) / std::sqrt(1.0 + a * a)) / (2.0 * kPi);
  return 2.0 * half;
}

TEST(FootShade, OfAWallIsWhatTheFormulaSays) {
  constexpr float kWidth_m = 60.0f, kHeight_m = 10.0f;
  ModelPart wall;
  add_quad(wall, {-0.5f * kWidth_m, 0, 0}, {kWidth_m, 0, 0}, {0, kHeight_m, 0});
  const auto sky = must(sky_over_ground(with_ground(wall), model_to_world({.east_m = 900.0, .north_m = 2000.0})));
  const FootShade shade = sky->under(even_sky());
  double worst = 0.0;
  for (const double distance_m : {0.7, 1.0, 2.0, 5.0, 10.0, 20.0}) {
    const double seen = seen_at(shade, 900.0, 2000.0 - distance_m);
    const double expected = 1.0 - hidden_by_wall(0.5 * double(kWidth_m), double(kHeight_m), distance_m);
    fmt::print("{:4.1f} m before a wall of {} m: {:.4f} of the sky, by the formula {:.4f}; an endless one {:.4f}\n",
               distance_m, kHeight_m, seen, expected,
               0.5 * (1.0 + distance_m / std::hypot(distance_m, double(kHeight_m))));
    worst = std::max(worst, std::abs(seen - expected));
  }
  EXPECT_LE(worst, 0.006);
}

TEST(FootShade, UnderARoofOnPillarsIsWhatTheFormulaSays) {
  constexpr double kSide_m = 12.0, kUp_m = 4.0;
  ModelPart roof;
  add_quad(roof, {-0.5f * float(kSide_m), float(kUp_m), 0.5f * float(kSide_m)}, {float(kSide_m), 0, 0},
           {0, 0, -float(kSide_m)});
  add_quad(roof, {-0.05f, 0, 0}, {0.1f, 0, 0}, {0, 0.1f, 0});  // the object reaches to the ground
  const auto sky = must(sky_over_ground(with_ground(roof), model_to_world({})));
  const FootShade shade = sky->under(even_sky());
  // A rectangle parallel to the element, each quarter above its corner (Siegel and Howell's C-1).
  const double a = 0.5 * kSide_m / kUp_m, root = std::sqrt(1.0 + a * a);
  const double hidden = 4.0 / (2.0 * kPi) * 2.0 * (a / root * std::atan(a / root));
  const double seen = seen_at(shade, 0.3, 0.3);
  fmt::print("under a roof of {} m, {} m up: {:.4f} of the sky, by the formula {:.4f}\n", kSide_m, kUp_m, seen,
             1.0 - hidden);
  EXPECT_NEAR(seen, 1.0 - hidden, 0.01);
}

// A sky brighter towards one side, 1 + slope d.y: before an endless wall whose top stands at angle a, (1 - cos a) pi / 2 +
// slope 2 / 3 sin^2 a of its pi are hidden.
TEST(FootShade, IsThatOfTheSkysBrightParts) {
  constexpr double kAway_m = 4.0, kUp_m = 30.0;
  ModelPart wall;
  add_quad(wall, {-50, 0, 0}, {100, 0, 0}, {0, float(kUp_m), 0});
  const auto sky = must(sky_over_ground(with_ground(wall), model_to_world({})));
  const double top = std::atan2(kUp_m, kAway_m);
  for (const double slope : {1.0, 0.0, -1.0}) {
    const auto light =
        light_around_of([slope](const Direction& d) { return glm::dvec3{d.z > 0.0 ? 1.0 + slope * d.y : 0.0}; });
    const double hidden = (0.5 * kPi * (1.0 - std::cos(top)) + slope * 2.0 / 3.0 * std::sin(top) * std::sin(top)) / kPi;
    const double seen = seen_at(sky->under(light), 0.0, -kAway_m);
    fmt::print("sky of 1 {:+.0f} y, {:.0f} m before a wall of {:.0f} m: {:.4f}, by the formula {:.4f}\n", slope,
               kAway_m, kUp_m, seen, 1.0 - hidden);
    EXPECT_NEAR(seen, 1.0 - hidden, 0.03) << slope;
  }
}

TEST(FootShade, EndsWhereTheMapEndsAndIsNoneWithoutGround) {
  ModelPart wall;
  add_quad(wall, {-10, 0, 0}, {20, 0, 0}, {0, 8, 0});
  const Model model = with_ground(wall);
  const auto sky = must(sky_over_ground(model, model_to_world({})));
  const FootShade shade = sky->under(even_sky());
  const auto& seen = shade.sky_seen;
  for (int x = 0; x < seen.width(); ++x) {
    EXPECT_EQ(seen.at(x, 0), 1.0f);
    EXPECT_GE(seen.at(x, 1), 0.95f);
  }
  Model bare = model;
  bare.ground.clear();
  EXPECT_FALSE(sky_over_ground(bare, model_to_world({})));
}

}  // namespace
}  // namespace kasumi
