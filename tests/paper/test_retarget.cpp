// A scene under other air, against the spectrum and against the scene as it truly looks there.
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <glm/common.hpp>

#include "base/picture.hpp"
#include "estimator/horizon/horizon.hpp"
#include "estimator/photograph/land_around.hpp"
#include "estimator/photograph/picture_noise.hpp"
#include "estimator/photograph/retarget.hpp"
#include "tests/figures.hpp"
#include "tests/paper/generated_scene.hpp"

namespace kasumi {
namespace {

Image<glm::vec3> one_pixel(const glm::dvec3& value) {
  return {1, 1, glm::vec3(value)};
}

// One pixel per distance; the truth is computed from a spectrum of 1 nm steps.
TEST(Retarget, RetargetsASurfaceAsTheSpectralReferenceDoes) {
  const auto measure = spectral_measure(generic_sensitivity());
  const auto nodes = attenuation_nodes(measure);
  const glm::dvec3 surface{0.08, 0.15, 0.05}, horizon_s{0.5, 0.55, 0.6}, horizon_t{0.62, 0.63, 0.64};
  const std::vector<double> distances_m{100.0, 1000.0, 3500.0, 8000.0};
  const auto seen = [&](const std::optional<Turbidity>& t, const glm::dvec3& horizon, double distance_m) {
    const auto path = optical_path(300.0, 300.0, distance_m);
    const auto gamma = t ? attenuation_reference(measure, ScatteringModel::morales2017, *t, path) : glm::dvec3{1.0};
    return horizon * (surface * gamma + 1.0 - gamma);
  };
  using Air = std::optional<Turbidity>;
  for (const auto& [from, to] : {std::pair{Air{Turbidity{1.9}}, Air{Turbidity{4.36}}},
                                 {Air{Turbidity{3.0}}, Air{Turbidity{2.0}}},
                                 {Air{Turbidity{2.4}}, Air{}}}) {
    Image<glm::vec3> light(static_cast<int>(distances_m.size()), 1);
    RetargetGeometry depth{Image<float>(light.width(), 1), {}, 300.0};
    for (int x = 0; x < light.width(); ++x) {
      depth.distance_m.at(x, 0) = static_cast<float>(distances_m[static_cast<std::size_t>(x)]);
      light.at(x, 0) = seen(from, horizon_s, distances_m[static_cast<std::size_t>(x)]);
    }
    const auto result = retarget(light, depth, {from, one_pixel(horizon_s)}, {to, one_pixel(horizon_t)}, nodes);
    for (int x = 0; x < light.width(); ++x) {
      const auto expected = seen(to, horizon_t, distances_m[static_cast<std::size_t>(x)]);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(result.light.at(x, 0)[c], expected[c], 2e-3)
            << "distance " << distances_m[static_cast<std::size_t>(x)] << " m, channel " << c;
      EXPECT_EQ(result.restored.at(x, 0), 255);
    }
  }
}

// Grey haze, so that gains are known: at T 8 its transmission is e^-depth at every wavelength.
TEST(Retarget, MasksFaintPixelsAndLeavesFainterOnesMoreHaze) {
  AttenuationNodes nodes;
  for (std::size_t i = 0; i < nodes.weight.size(); ++i) {
    nodes.weight[i] = glm::dvec3{i == 0 ? 1.0 : 0.0};
    nodes.wavelength_nm[i] = glm::dvec3{550.0};
  }
  const double per_m = rayleigh_per_m(ScatteringModel::morales2017, 550.0) +
                       mie_per_m(ScatteringModel::morales2017, 550.0, Turbidity{8.0});
  // Gains of 4, 8 (the limit), 16 and 64, and a practically infinite one.
  const std::vector<double> gains{4.0, 7.99, 16.0, 64.0, 1e200}, allowed{4.0, 7.99, 4.0, 1.0, 1.0};
  const Image<glm::vec3> light(5, 1, glm::vec3(0.49F));
  RetargetGeometry depth{Image<float>(5, 1), {}, 0.0};
  // On a level path at sea level both densities are 1.
  for (int x = 0; x < 5; ++x)
    depth.distance_m.at(x, 0) = static_cast<float>(std::log(gains[static_cast<std::size_t>(x)]) / per_m);
  const auto result = retarget(light, depth, {Turbidity{8.0}, one_pixel(glm::dvec3{0.5})},
                               {std::nullopt, one_pixel(glm::dvec3{0.5})}, nodes);
  for (int x = 0; x < 5; ++x) {
    EXPECT_EQ(result.restored.at(x, 0), x < 2 ? 255 : 0) << x;
    EXPECT_NEAR(result.light.at(x, 0).g, 0.5 - 0.01 * allowed[static_cast<std::size_t>(x)], 2e-5) << x;
  }
  EXPECT_NEAR(result.too_faint_fraction, 0.6, 1e-9);
}

// The remainder is haze: every channel changes by the same fraction.
TEST(Retarget, GivesFaintPixelsNoColour) {
  const auto nodes = attenuation_nodes(spectral_measure(generic_sensitivity()));
  const Image<glm::vec3> light(1, 1, glm::vec3(0.49F));
  const RetargetGeometry depth{Image<float>(1, 1, 3500.0F), {}, 0.0};
  const auto result = retarget(light, depth, {Turbidity{8.0}, one_pixel(glm::dvec3{0.5})},
                               {std::nullopt, one_pixel(glm::dvec3{0.5})}, nodes);
  ASSERT_EQ(result.restored.at(0, 0), 0);
  EXPECT_GE(result.light.at(0, 0).b, 0.5 - 8.0 * 0.01) << "blue, which haze attenuates most, is within the limit";
  EXPECT_GT(result.light.at(0, 0).r, result.light.at(0, 0).b);
  EXPECT_LT(result.light.at(0, 0).r, 0.49F);
}

TEST(Retarget, KeepsThePictureWhenNothingChanges) {
  const auto nodes = attenuation_nodes(spectral_measure(generic_sensitivity()));
  Image<glm::vec3> light(64, 1);
  RetargetGeometry depth{Image<float>(64, 1), {}, 0.0};
  for (int x = 0; x < 64; ++x) {
    light.at(x, 0) = glm::vec3(0.01F * static_cast<float>(x), 0.3F, 0.7F);
    depth.distance_m.at(x, 0) = 400.0F * static_cast<float>(x);  // the first is sky
  }
  const RetargetAir air{Turbidity{3.0}, one_pixel({0.4, 0.45, 0.5})};
  const auto result = retarget(light, depth, air, air, nodes);
  for (int x = 0; x < 64; ++x)
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(result.light.at(x, 0)[c], light.at(x, 0)[c], 1e-6F);
}

RetargetAir measured_air(const Scene& scene, double turbidity) {
  const auto horizon = measure_horizon(scene.camera, view_of(scene.picture));
  EXPECT_TRUE(horizon.usable()) << horizon.reason;
  const Airlight airlight(horizon, Turbidity{turbidity}, scene.sun, scene.camera.light_to_xyz());
  return {Turbidity{turbidity}, light_from_infinity(scene.camera, airlight)};
}

Image<glm::vec3> without_noise_of(const Scene& scene) {
  Image<glm::vec3> encoded(scene.picture.width(), scene.picture.height());
  for (std::size_t i = 0; i < encoded.elements().size(); ++i)
    encoded.elements()[i] = glm::vec3(scene.picture.elements()[i]) / 255.0F;
  auto clean = without_noise(encoded, noise_of(encoded));
  for (int y = 0; y < clean.height(); ++y)
    for (int x = 0; x < clean.width(); ++x) clean.at(x, y) = scene.camera.light_at({x, y}, glm::dvec3(clean.at(x, y)));
  return clean;
}

// Mean absolute difference of the encoded pictures where the source could be restored, in levels of 255.
struct Difference {
  double land = 0.0, all = 0.0, masked = 0.0;
};
Difference between(const Scene& truth, const Retargeted& made) {
  Difference found;
  double land_pixels = 0.0, pixels = 0.0;
  for (int y = 0; y < truth.picture.height(); ++y)
    for (int x = 0; x < truth.picture.width(); ++x) {
      if (made.restored.at(x, y) == 0) continue;
      const auto light =
          glm::dvec3(made.light.at(x, y)) * truth.camera.white_balance * truth.camera.vignetting.at({x, y});
      const auto encoded = glm::clamp(truth.camera.response.to_encoded(light), 0.0, 1.0);
      const auto off = glm::abs(255.0 * encoded - glm::dvec3(truth.picture.at(x, y)));
      const double mean = (off.r + off.g + off.b) / 3.0;
      found.all += mean;
      pixels += 1.0;
      if (!(truth.distance_m.at(x, y) > 0.0F)) continue;
      found.land += mean;
      land_pixels += 1.0;
    }
  found.land /= land_pixels;
  found.all /= pixels;
  found.masked = made.too_faint_fraction;
  return found;
}

// M Sect 6.2's values, the airlight taken from the target picture's own horizon as M does; then the other way, which M
// does not show: haze removed.
TEST(Retarget, RetargetsAGeneratedSceneToThePapersAirs) {
  fmt::print(
      "| T | land, of 255 | whole picture | with M's rho kept | not touched | too faint |\n"
      "|---|---|---|---|---|---|\n");
  using Airs = std::pair<double, double>;
  const auto land = land_at({});
  for (const auto& [from, to] : figure_cases<Airs>("airs", {{1.9, 2.94}, {2.94, 1.9}},
                                                   {{1.9, 2.11}, {1.9, 2.54}, {1.9, 2.94}, {1.9, 4.36}, {2.94, 1.9}})) {
    const Scene source = scene_at(land, from, 11), target = scene_at(land, to, 12);
    const auto nodes = attenuation_nodes(spectral_measure(source.camera));
    const RetargetGeometry depth{source.distance_m, rise_of(source.camera), source.altitude_m};
    RetargetLimits options;
    options.relit = relighting(source.camera, Turbidity{from}, Turbidity{to}, source.sun,
                               source.camera.direction_at({160, 90}).value(), source.altitude_m);
    const auto source_air = measured_air(source, from), target_air = measured_air(target, to);
    const auto made = retarget(source.light, depth, source_air, target_air, nodes, options,
                               {without_noise_of(source), land_around(source.light, depth, source_air, nodes)});
    const auto plain = retarget(source.light, depth, source_air, target_air, nodes);
    const Retargeted untouched{source.light, Image<std::uint8_t>(320, 180, 255), 0.0};
    const auto found = between(target, made), kept = between(target, plain), none = between(target, untouched);
    fmt::print("| {} -> {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.1f} % |\n", from, to, found.land, found.all,
               kept.land, none.land, 100.0 * found.masked);
    figure_row("retargeted",
               {fmt::format("{} to {}", from, to), figure_text(found.land, 2), figure_text(found.all, 2),
                figure_text(kept.land, 2), figure_text(none.land, 2), figure_text(100.0 * found.masked, 1) + " %"});
    EXPECT_LE(found.land, 2.0) << from << " -> " << to;
    EXPECT_LE(found.all, 2.0) << from << " -> " << to;
    EXPECT_LT(found.land, none.land) << "it must be closer than the unchanged picture";
  }
}

}  // namespace
}  // namespace kasumi
