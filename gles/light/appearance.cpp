#include "gles/light/appearance.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "base/units.hpp"
#include "gles/light/airlight_grid.hpp"

namespace kasumi {
namespace {

// Radiance of a horizontal white card in the open, under sun and sky.
glm::dvec3 white_card(const ObjectLight& light) {
  return (irradiance(light.around, {0, 0, 1}) + light.sun_irradiance * std::max(light.sun_direction.z, 0.0)) / kPi;
}

bool finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}
bool not_negative(const glm::dvec3& v) {
  return finite(v) && v.x >= 0.0 && v.y >= 0.0 && v.z >= 0.0;
}

}  // namespace

void check(const ObjectAppearance& appearance, Problems& problems) {
  const Haze& haze = appearance.haze;
  for (int k = 0; k < kHazeNodes; ++k) {
    const auto node = static_cast<std::size_t>(k);
    if (!finite(haze.weight[node]) || !not_negative(haze.rayleigh_per_m[node]) || !not_negative(haze.mie_per_m[node]))
      problems.add("haze: node {}: expected finite weights and scattering coefficients >= 0", k);
  }
  if (!(haze.rayleigh_scale_height_m > 0.0) || !(haze.mie_scale_height_m > 0.0))
    problems.add("haze: scale heights {} m and {} m: expected numbers > 0", haze.rayleigh_scale_height_m,
                 haze.mie_scale_height_m);
  if (!std::isfinite(haze.observer_altitude_m))
    problems.add("haze: observer's altitude: expected a finite number of metres");
  if (!std::isfinite(haze.fog_per_m) || haze.fog_per_m < 0.0 || !std::isfinite(haze.fog_base_altitude_m) ||
      !(haze.fog_scale_height_m > 0.0))
    problems.add(
        "haze: fog of {} /m at {} m, scale height {} m: expected an extinction >= 0, a finite altitude, a height > 0",
        haze.fog_per_m, haze.fog_base_altitude_m, haze.fog_scale_height_m);
  const ObjectLight& light = appearance.light;
  if (!finite(light.sun_direction) || std::abs(glm::length(light.sun_direction) - 1.0) > 1e-6)
    problems.add("light: sun direction ({}, {}, {}): expected a unit vector", light.sun_direction.x,
                 light.sun_direction.y, light.sun_direction.z);
  if (!not_negative(light.sun_irradiance)) problems.add("light: sun irradiance: expected finite numbers >= 0");
  const auto& around = light.around.radiance;
  if (around.width() != LightAround::kSize || around.height() != LightAround::kSize)
    problems.add("light: surroundings of {} x {} texels: expected {} x {}", around.width(), around.height(),
                 LightAround::kSize, LightAround::kSize);
  if (!std::ranges::all_of(around.elements(), [](const glm::vec3& texel) { return not_negative(texel); }))
    problems.add("light: surroundings: expected finite numbers >= 0");
  check(appearance.horizon, "horizon", true, problems);
}

void check(const SensorNoise& noise, Problems& problems) {
  if (!not_negative(noise.shot) || !not_negative(noise.read)) problems.add("noise: expected finite numbers >= 0");
}

double largest_n(const ObjectAppearance& appearance, const RadianceAtlas& sky,
                 std::span<const ModelMaterial> materials) {
  const ObjectLight& light = appearance.light;
  const bool mirrors = std::ranges::any_of(materials, &ModelMaterial::reflects);
  glm::dvec3 radiance = (light.sun_irradiance + sky.brightest_irradiance()) / kPi;
  if (mirrors) radiance = glm::max(radiance, light.sun_irradiance / kPi + sky.brightest_radiance());
  glm::dvec3 emission{0.0};
  for (const ModelMaterial& material : materials) {
    const glm::dvec3 shown = light.albedo_to_channels * glm::dvec3(material.emission);
    emission = glm::max(emission, shown);
    if (material.unlit) radiance = glm::max(radiance, white_card(light));
  }
  radiance += emission * white_card(light);
  constexpr double kBytes = 1.01;  // margin for rounding of the surroundings to bytes
  double largest = 1.0;
  for (const glm::dvec3& horizon : appearance.horizon.light)
    for (int c = 0; c < 3; ++c) largest = std::max(largest, kBytes * radiance[c] / horizon[c]);
  return largest;
}

void set_appearance(const Program& program, const ObjectAppearance& appearance) {
  const Haze& haze = appearance.haze;
  constexpr double kPerKm = 1000.0;
  std::array<glm::dvec3, kHazeNodes> rayleigh, mie;
  for (std::size_t k = 0; k < kHazeNodes; ++k) {
    rayleigh[k] = kPerKm * haze.rayleigh_per_m[k];
    mie[k] = kPerKm * haze.mie_per_m[k];
  }
  program.set("haze_weight", haze.weight);
  program.set("haze_rayleigh_per_km", rayleigh);
  program.set("haze_mie_per_km", mie);
  const glm::dvec2 heights{haze.rayleigh_scale_height_m, haze.mie_scale_height_m};
  program.set("observer_density", glm::exp(-haze.observer_altitude_m / heights));
  program.set("inverse_scale_height_km", kPerKm / heights);
  program.set("fog_per_km", kPerKm * haze.fog_per_m);
  program.set("observer_above_fog", (haze.observer_altitude_m - haze.fog_base_altitude_m) / haze.fog_scale_height_m);
  program.set("inverse_fog_height_km", kPerKm / haze.fog_scale_height_m);

  const ObjectLight& light = appearance.light;
  program.set("sun_direction", light.sun_direction);
  program.set("albedo_to_channels", light.albedo_to_channels);
  program.set("sun_light", light.sun_irradiance / kPi);
  program.set("white_card", white_card(light));
  set_airlight(program, "horizon", appearance.horizon);
}

}  // namespace kasumi
