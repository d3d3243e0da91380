// A ball in front of the scene camera, drawn by the GPU under the estimator's sky, against that sky integrated
// numerically: the light on its surface, and its reflection.
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "estimator/light/object_light.hpp"
#include "gles/composite/renderer.hpp"
#include "pipeline/show/scene/for_gles.hpp"
#include "tests/figures.hpp"

namespace kasumi {
namespace {

using Radiance = std::function<glm::dvec3(const Direction&)>;

constexpr int kPicture = 140;
constexpr double kDistance_m = 3500.0, kRadius_m = 20.0, kRadius_px = 64.0;

Direction at_deg(double zenith, double azimuth) {
  return direction_from(from_degrees(zenith), from_degrees(azimuth));
}

Model ball(const ModelMaterial& material) {
  constexpr int kSteps = 90;
  Model model;
  model.materials = {material};
  ModelPart part;
  for (int j = 0; j <= kSteps; ++j)
    for (int i = 0; i <= 2 * kSteps; ++i) {
      const Direction normal = direction_from({kPi * j / kSteps}, {kPi * i / kSteps});
      const glm::vec3 in_model{normal.x, normal.z, -normal.y};  // glTF: y up, -z north
      part.vertices.push_back({.position = float(kRadius_m) * in_model, .normal = in_model});
    }
  const auto at = [](int i, int j) { return static_cast<std::uint32_t>(j * (2 * kSteps + 1) + i); };
  for (int j = 0; j < kSteps; ++j)
    for (int i = 0; i < 2 * kSteps; ++i)
      part.indices.insert(part.indices.end(),
                          {at(i, j), at(i + 1, j + 1), at(i, j + 1), at(i, j), at(i + 1, j), at(i + 1, j + 1)});
  model.parts = {part};
  return model;
}

// The point of the ball that a pixel shows.
struct Place {
  glm::ivec2 pixel;
  Direction normal;
  Direction to_eye;
};

// All over the visible side, to within 25 deg of the rim; the camera looks north.
std::vector<Place> places() {
  std::vector<Place> list;
  for (int y = 5; y < kPicture; y += 9)
    for (int x = 5; x < kPicture; x += 9) {
      const double scale = kRadius_m / kRadius_px / kDistance_m, middle = 0.5 * (kPicture - 1);
      const Direction ray = glm::normalize(glm::dvec3{(x - middle) * scale, 1.0, (middle - y) * scale});
      const double along = kDistance_m * ray.y;
      const double inside = kRadius_m * kRadius_m - (kDistance_m * kDistance_m - along * along);
      if (inside <= 0.0) continue;
      const Direction normal = ((along - std::sqrt(inside)) * ray - glm::dvec3{0.0, kDistance_m, 0.0}) / kRadius_m;
      if (glm::dot(normal, -ray) > 0.42) list.push_back({{x, y}, normal, -ray});
    }
  return list;
}

class Ball : public testing::Test {
 protected:
  void SetUp() override {
    auto context = open_headless_context();
    if (!context) GTEST_SKIP() << context.error().message;
    context_ = std::move(*context);
    renderer_.emplace(Renderer::create(*context_).value());
    SceneView view{.width = kPicture, .height = kPicture};
    view.focal_px = glm::dvec2{kRadius_px * kDistance_m / kRadius_m};
    view.centre_px = glm::dvec2{0.5 * (kPicture - 1)};
    view.world_to_camera = glm::dmat4{{1, 0, 0, 0}, {0, 0, 1, 0}, {0, -1, 0, 0}, {0, 0, 0, 1}};
    ASSERT_TRUE(renderer_->set_view(view, model_to_world({.north_m = kDistance_m})));
  }

  // Radiance of each point as the renderer draws it.
  std::vector<glm::dvec3> drawn(const ModelMaterial& material, const ObjectLight& light) {
    EXPECT_TRUE(renderer_->set_model(ball(material)));
    return drawn(light);
  }
  std::vector<glm::dvec3> drawn(const ObjectLight& light) {
    ObjectAppearance look;
    look.aerial_perspective = false;
    look.light = light;
    look.horizon.last_px = {1.0, 1.0};
    const double unit = irradiance(light.around, {0.0, 0.0, 1.0}).y;
    look.horizon.light.fill(glm::dvec3{unit});
    EXPECT_TRUE(renderer_->redraw_layer(look));
    const auto layer = renderer_->read_layer().value();
    const PixelBox box = renderer_->object_box();
    std::vector<glm::dvec3> radiances;
    for (const Place& place : places_) {
      const glm::vec4 texel = layer.at(place.pixel.x - box.left, place.pixel.y - box.top);
      EXPECT_EQ(texel.a, 1.0f);
      radiances.push_back(unit * glm::dvec3(texel));
    }
    return radiances;
  }

  std::unique_ptr<GlContext> context_;
  std::optional<Renderer> renderer_;
  const std::vector<Place> places_ = places();
};

// The whole sphere in small cones: direction, and radiance times solid angle.
struct Cone {
  Direction direction;
  glm::dvec3 power;
};
std::vector<Cone> cones_of(const Radiance& radiance) {
  constexpr int kZeniths = 180, kAzimuths = 120;
  std::vector<Cone> cones;
  for (int i = 0; i < kZeniths; ++i) {
    const double upper = kPi * i / kZeniths, lower = kPi * (i + 1) / kZeniths;
    const double solid_angle = 2.0 * kPi / kAzimuths * (std::cos(upper) - std::cos(lower));
    for (int j = 0; j < kAzimuths; ++j) {
      const Direction d = direction_from({0.5 * (upper + lower)}, {2.0 * kPi * (j + 0.5) / kAzimuths});
      cones.push_back({d, solid_angle * radiance(d)});
    }
  }
  return cones;
}
glm::dvec3 gathered(const std::vector<Cone>& cones, const Direction& normal) {
  glm::dvec3 sum{0.0};
  for (const Cone& cone : cones) sum += std::max(0.0, glm::dot(cone.direction, normal)) * cone.power;
  return sum;
}

// The estimator's sky over its uniform ground.
struct Day {
  Daylight daylight;
  ObjectLight light;
  glm::dvec3 ground;

  Day(double turbidity, const SunDirection& sun)
      : daylight(Camera{}, Turbidity{turbidity}, sun), light(light_for_gles(daylight.on_object())) {
    const glm::dvec3 sky = gathered(
        cones_of([&](const Direction& d) { return d.z > 0.0 ? daylight.airlight(d) : glm::dvec3{0.0}; }), {0, 0, 1});
    ground = DaylightConditions{}.ground_albedo / kPi * (sky + std::max(0.0, sun.z) * light.sun_irradiance);
  }
  glm::dvec3 operator()(const Direction& d) const { return d.z > 0.0 ? daylight.airlight(d) : ground; }
};

TEST_F(Ball, OfGreyPlasterIsLitAsTheIntegralOverSunSkyAndGround) {
  // Sun behind the camera, to the side, and behind the ball.
  constexpr double kAlbedo = 0.5;
  const ModelMaterial plaster{.name = "plaster", .base_colour = {kAlbedo, kAlbedo, kAlbedo, 1.0f}};
  ASSERT_TRUE(renderer_->set_model(ball(plaster)));
  double least = 1.0, most = 0.0;
  for (const double turbidity : {2.0, 4.0, 8.0, 2.7})
    for (const double zenith : {20.0, 45.0, 60.0, 75.0, 85.0, 33.0, 82.0}) {
      const double azimuth = zenith < 50.0 ? 190.0 : zenith < 80.0 ? 265.0 : 20.0;
      const Day day(turbidity, at_deg(zenith, azimuth));
      const auto found = drawn(day.light);
      const auto cones = cones_of(day);
      double worst = 0.0;
      for (std::size_t i = 0; i < places_.size(); ++i) {
        const glm::dvec3 sun =
            std::max(0.0, glm::dot(places_[i].normal, day.light.sun_direction)) * day.light.sun_irradiance;
        const glm::dvec3 truth = kAlbedo / kPi * (sun + gathered(cones, places_[i].normal));
        for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(found[i][c] / truth[c] - 1.0));
      }
      fmt::print("T {}, sun {} deg from the zenith at {} deg: worst {:.2f} %\n", turbidity, zenith, azimuth,
                 100.0 * worst);
      EXPECT_LE(worst, 0.02) << "T " << turbidity << ", sun " << zenith;
      least = std::min(least, worst);
      most = std::max(most, worst);
    }
  figure_row("ball-plaster",
             {"grey plaster under sun, sky and ground, T 2 to 8, sun 20 to 85 deg from the zenith: worst place",
              figure_range(100.0 * least, 100.0 * most, 1) + " %"});
}

// Light that one reflection by GGX facets sends to the eye, and its fraction under uniform light (glTF 2.0, B.3; white
// metal). Facets by tilt, tan(tilt) = alpha t / (1 - t), and azimuth.
std::pair<glm::dvec3, double> reflected(const Radiance& radiance, const Place& place, double roughness) {
  constexpr int kTilts = 48, kTurns = 48;
  const double alpha = roughness * roughness, a2 = alpha * alpha;
  const glm::dvec3 n = place.normal;
  const glm::dvec3 x = glm::normalize(glm::cross(n, std::abs(n.z) < 0.9 ? glm::dvec3{0, 0, 1} : glm::dvec3{1, 0, 0}));
  const glm::dvec3 y = glm::cross(n, x);
  const double nv = glm::dot(n, place.to_eye);
  const auto lambda = [&](double cosine) {
    return 0.5 * (std::sqrt(1.0 + a2 * (1.0 / (cosine * cosine) - 1.0)) - 1.0);
  };
  glm::dvec3 sum{0.0};
  double even = 0.0;
  for (int i = 0; i < kTilts; ++i) {
    const double t = (i + 0.5) / kTilts, tangent = alpha * t / (1.0 - t), slope = alpha / ((1.0 - t) * (1.0 - t));
    const double nh = 1.0 / std::sqrt(1.0 + tangent * tangent), sine = tangent * nh;
    const double solid_angle = sine * slope * nh * nh / kTilts * 2.0 * kPi / kTurns;
    for (int j = 0; j < kTurns; ++j) {
      const double turn = 2.0 * kPi * (j + 0.5) / kTurns;
      const glm::dvec3 h = nh * n + sine * (std::cos(turn) * x + std::sin(turn) * y);
      const double vh = glm::dot(place.to_eye, h);
      const Direction l = 2.0 * vh * h - place.to_eye;
      const double nl = glm::dot(n, l);
      if (vh <= 0.0 || nl <= 0.0) continue;
      const double d = nh * nh * (a2 - 1.0) + 1.0;
      const double share = a2 / (kPi * d * d) / (1.0 + lambda(nl) + lambda(nv)) * vh / nv * solid_angle;
      sum += share * radiance(l);
      even += share;
    }
  }
  return {sum, even};
}

struct Deviation {
  double mean = 0.0;
  double worst = 0.0;
};

TEST_F(Ball, OfPolishedToMattMetalMirrorsTheSkyAsTheIntegralOverItsFacets) {
  const Day noon(3.0, at_deg(40.0, 215.0)), evening(2.2, at_deg(80.0, 230.0));
  // Cumulus clouds all over a clear sky, three times its brightness.
  const Radiance clouds = [&](const Direction& d) {
    const glm::dvec3 clear = noon(d);
    if (d.z <= 0.0) return clear;
    const double heap = std::sin(5.0 * d.x + 1.0) * std::sin(4.0 * d.y) + 0.5 * std::sin(9.0 * d.x - 7.0 * d.y);
    const double cover = std::clamp(4.0 * heap, 0.0, 1.0);
    return clear * (1.0 - cover) + cover * 3.0 * glm::dvec3{clear.g};
  };
  struct Sky {
    const char* name;
    Radiance radiance;
    double most;  // mean deviation
    const char* words;
  };
  for (const Sky& sky : {Sky{"clear", noon, 0.025, "clear, sun at 40 deg"},
                         Sky{"low sun", evening, 0.06, "clear, sun at 80 deg, no disc"},
                         Sky{"clouds", clouds, 0.05, "heaps of cloud three times as bright as the sky"}}) {
    ObjectLight light;
    light.around = light_around_of(sky.radiance);
    const auto cones = cones_of(sky.radiance);
    std::array<double, 3> least{1e9, 1e9, 1e9}, most{};  // mean, worst, level
    for (const double roughness : {0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0}) {
      ModelMaterial metal{.name = "metal"};
      metal.metallic = 1.0f;
      metal.roughness = float(roughness);
      const auto found = drawn(metal, light);
      Deviation deviation;
      glm::dvec3 level{0.0};
      for (std::size_t i = 0; i < places_.size(); ++i) {
        const auto [once, even] = reflected(sky.radiance, places_[i], roughness);
        // Light reflected between white facets leaves diffusely.
        const glm::dvec3 truth = once + (1.0 - even) * gathered(cones, places_[i].normal) / kPi;
        for (int c = 0; c < 3; ++c) {
          const double error = std::abs(found[i][c] / truth[c] - 1.0);
          deviation.worst = std::max(deviation.worst, error);
          deviation.mean += error / (3.0 * double(places_.size()));
        }
        level += found[i] / truth / double(places_.size());
      }
      fmt::print("{}, roughness {}: mean {:.1f} %, worst {:.1f} %, level {:.3f}\n", sky.name, roughness,
                 100.0 * deviation.mean, 100.0 * deviation.worst, level.g);
      EXPECT_LE(deviation.mean, sky.most) << sky.name << ", roughness " << roughness;
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(level[c], 1.0, 0.025) << sky.name << ", roughness " << roughness;
      const std::array measured{100.0 * deviation.mean, 100.0 * deviation.worst, level.g};
      for (std::size_t i = 0; i < measured.size(); ++i) {
        least[i] = std::min(least[i], measured[i]);
        most[i] = std::max(most[i], measured[i]);
      }
    }
    figure_row("ball-mirrors", {sky.words, figure_range(least[0], most[0], 1) + " %",
                                figure_range(least[1], most[1], 0) + " %", figure_range(least[2], most[2], 3)});
  }
}

}  // namespace
}  // namespace kasumi
