#include "estimator/sky/hosek.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "estimator/sky/tensor_file.hpp"

namespace kasumi {
namespace {

// The layout of their data file (docs/sky.md)
constexpr int kTurbidities = 10, kAlbedos = 2, kControlPoints = 6, kNumbers = 9;
// Their colours are sums over the spectrum, weighted by CIE 1931's curves at 1 nm, whose y adds up to this.
constexpr double kEyeWidth_nm = 106.856980;

// (1 + A e^(B / (cos theta + .01))) (C + D e^(E gamma) + F cos^2 gamma + G chi(H, gamma) + I sqrt(cos theta)), their
// Eq 8; chi widens the aureole. The data have I before H.
double value(const HosekForm& form, double cos_theta, double sqrt_cos_theta, double cos_gamma, double gamma_rad) {
  const auto& [a, b, c, d, e, f, g, i, h] = form.shape;
  const double lobe = 1.0 + h * h - 2.0 * h * cos_gamma, squared = cos_gamma * cos_gamma;
  const double chi = (1.0 + squared) / (lobe * std::sqrt(lobe));
  return form.radiance * (1.0 + a * std::exp(b / (cos_theta + 0.01))) *
         (c + d * std::exp(e * gamma_rad) + f * squared + g * chi + i * sqrt_cos_theta);
}

// What a direction is to the sky, for all its colours.
struct SeenAt {
  SeenAt(double cos_zenith, double cos_sun_distance)
      : cos_theta(std::clamp(cos_zenith, 0.0, 1.0)),
        sqrt_cos_theta(std::sqrt(cos_theta)),
        cos_gamma(std::clamp(cos_sun_distance, -1.0, 1.0)),
        gamma_rad(std::acos(cos_gamma)) {}
  double operator()(const HosekForm& form) const {
    return std::max(0.0, value(form, cos_theta, sqrt_cos_theta, cos_gamma, gamma_rad));
  }

  double cos_theta, sqrt_cos_theta, cos_gamma, gamma_rad;
};

double elevation_rad(const SunDirection& sun) {
  return std::asin(std::clamp(sun.z, 0.0, 1.0));
}

}  // namespace

glm::dvec3 HosekRadiance::linear_srgb(double cos_zenith, double cos_sun_distance) const {
  const SeenAt seen(cos_zenith, cos_sun_distance);
  return glm::dvec3(seen(colours_[0]), seen(colours_[1]), seen(colours_[2])) / kEyeWidth_nm;
}

HosekForm HosekSky::Tables::form(int channel, double turbidity, double ground_albedo, double sun_elevation_rad) const {
  const double t = std::clamp(turbidity, kLowest.value, kHighest.value) - 1.0;
  const int below = std::min(static_cast<int>(t), kTurbidities - 2);
  const double albedo = std::clamp(ground_albedo, 0.0, 1.0);
  // Control points of a Bezier curve over the cube root of the elevation, close together where the sun is low.
  const double x = std::cbrt(sun_elevation_rad / (0.5 * std::numbers::pi));
  constexpr std::array<double, kControlPoints> kBinomials{1.0, 5.0, 10.0, 10.0, 5.0, 1.0};  // 5 over k
  HosekForm form;
  for (const int high : {0, 1})
    for (const int white : {0, 1})
      for (int point = 0; point < kControlPoints; ++point) {
        const double weight = (high ? t - below : below + 1 - t) * (white ? albedo : 1.0 - albedo) *
                              kBinomials[static_cast<std::size_t>(point)] * std::pow(x, point) *
                              std::pow(1.0 - x, kControlPoints - 1 - point);
        const auto at = static_cast<std::size_t>(
            (((below + high) * kAlbedos + white) * kControlPoints + point) * channels + channel);
        form.radiance += weight * radiance[at];
        for (std::size_t k = 0; k < kNumbers; ++k) form.shape[k] += weight * shape[at * kNumbers + k];
      }
  return form;
}

Result<HosekSky> HosekSky::read_file(const std::filesystem::path& file) {
  const auto tensors = TensorFile::read(file);
  if (!tensors) return fail(tensors.error());
  HosekSky sky;
  const auto read = [&](Tables& tables, const std::string& kind, int channels) -> Result<> {
    std::vector<std::size_t> extents{kTurbidities, kAlbedos, kControlPoints, static_cast<std::size_t>(channels)};
    auto radiance = tensors->doubles("sky_rad_" + kind, extents);
    if (!radiance) return fail(radiance.error());
    extents.push_back(kNumbers);
    auto shape = tensors->doubles("sky_params_" + kind, extents);
    if (!shape) return fail(shape.error());
    tables = {channels, std::move(*shape), std::move(*radiance)};
    return {};
  };
  if (auto done = read(sky.rgb_, "rgb", 3); !done) return fail(done.error());
  if (auto done = read(sky.spectral_, "spec", kWavelengths); !done) return fail(done.error());
  return sky;
}

HosekRadiance HosekSky::sky(Turbidity turbidity, double ground_albedo, const SunDirection& sun) const {
  std::array<HosekForm, 3> colours;
  for (int i = 0; i < 3; ++i)
    colours[static_cast<std::size_t>(i)] = rgb_.form(i, turbidity.value, ground_albedo, elevation_rad(sun));
  return {colours, sun};
}

std::array<double, HosekSky::kWavelengths> HosekSky::spectral_radiance(Turbidity turbidity, double ground_albedo,
                                                                       const SunDirection& sun,
                                                                       const Direction& view) const {
  const SeenAt seen(view.z, glm::dot(view, sun));
  std::array<double, kWavelengths> light;
  for (int i = 0; i < kWavelengths; ++i)
    light[static_cast<std::size_t>(i)] = seen(spectral_.form(i, turbidity.value, ground_albedo, elevation_rad(sun)));
  return light;
}

}  // namespace kasumi
