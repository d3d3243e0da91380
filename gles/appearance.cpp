#include "gles/appearance.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "base/units.hpp"
#include "gles/airlight.hpp"

namespace kasumi {
namespace {

// Constants of the real SH basis in the order of ObjectLight.
constexpr std::array<double, 9> kBasis{0.28209479177387814, 0.4886025119029199, 0.4886025119029199,
                                       0.4886025119029199,  1.0925484305920792, 1.0925484305920792,
                                       0.31539156525252005, 1.0925484305920792, 0.5462742152960396};

// The harmonics' sum, each order times a factor.
glm::dvec3 sky_sum(const ObjectLight& light, const glm::dvec3& n, const std::array<double, 3>& factors) {
  const auto& sh = light.sky_irradiance_sh;
  const std::array<double, 9> terms{
      1.0, n.y, n.z, n.x, n.x * n.y, n.y * n.z, 3.0 * n.z * n.z - 1.0, n.x * n.z, n.x * n.x - n.y * n.y};
  glm::dvec3 sum{0.0};
  for (std::size_t i = 0; i < terms.size(); ++i)
    sum += factors[i == 0 ? 0 : i < 4 ? 1 : 2] * kBasis[i] * terms[i] * sh[i];
  return glm::max(sum, glm::dvec3{0.0});
}

glm::dvec3 sky_irradiance(const ObjectLight& light, const glm::dvec3& n) {
  return sky_sum(light, n, {1.0, 1.0, 1.0});
}

// What a smooth mirror shows of the sky, times pi.
glm::dvec3 mirrored_sky(const ObjectLight& light, const glm::dvec3& towards) {
  return sky_sum(light, towards, {1.0, 1.5, 4.0});
}

// Radiance of a white card lying in the open.
glm::dvec3 white_card(const ObjectLight& light) {
  return (sky_irradiance(light, {0, 0, 1}) + light.sun_irradiance * std::max(light.sun_direction.z, 0.0)) / kPi;
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
  if (!std::ranges::all_of(light.sky_irradiance_sh, finite))
    problems.add("light: sky irradiance: expected finite coefficients");
  check(appearance.horizon, "horizon", true, problems);
}

void check(const SensorNoise& noise, Problems& problems) {
  if (!not_negative(noise.shot) || !not_negative(noise.read)) problems.add("noise: expected finite numbers >= 0");
}

double largest_n(const ObjectAppearance& appearance, std::span<const ModelMaterial> materials) {
  constexpr int kDirections = 512;  // evenly over the sphere: between two of them order 2 changes by percents
  constexpr double kBetween = 1.05;
  const ObjectLight& light = appearance.light;
  const bool mirrors = std::ranges::any_of(materials, &ModelMaterial::reflects);
  glm::dvec3 from_sky{0.0}, brightest{0.0};
  const auto look = [&](const glm::dvec3& n) {
    const glm::dvec3 matt = sky_irradiance(light, n);
    if (mirrors) from_sky = glm::max(from_sky, glm::max(matt, mirrored_sky(light, n)));
    brightest = glm::max(brightest, light.sun_irradiance * std::max(glm::dot(n, light.sun_direction), 0.0) + matt);
  };
  look(light.sun_direction);
  for (int i = 0; i < kDirections; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kDirections;
    const double turn = i * kPi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    look({r * std::cos(turn), r * std::sin(turn), z});
  }
  if (mirrors) brightest = glm::max(brightest, light.sun_irradiance + from_sky);
  glm::dvec3 radiance = brightest / kPi;
  glm::dvec3 emission{0.0};
  for (const ModelMaterial& material : materials) {
    const glm::dvec3 shown = light.albedo_to_channels * glm::dvec3(material.emission);
    emission = glm::max(emission, shown);
    if (material.unlit) radiance = glm::max(radiance, white_card(light));
  }
  radiance += emission * white_card(light);
  double largest = 1.0;
  for (const glm::dvec3& horizon : appearance.horizon.light)
    for (int c = 0; c < 3; ++c) largest = std::max(largest, kBetween * radiance[c] / horizon[c]);
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
  std::array<glm::dvec3, 9> sky;
  for (std::size_t i = 0; i < sky.size(); ++i) sky[i] = light.sky_irradiance_sh[i] * kBasis[i] / kPi;
  program.set("sky_light", sky);
  program.set("white_card", white_card(light));
  set_airlight(program, "horizon", appearance.horizon);
}

}  // namespace kasumi
