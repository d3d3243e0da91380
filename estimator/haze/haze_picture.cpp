#include "estimator/haze/haze_picture.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/exponential.hpp>

namespace kasumi {

glm::dvec3 HazeOptics::transmission(double range) const {
  glm::dvec3 left{0.0};
  for (std::size_t k = 0; k < weight.size(); ++k) left += weight[k] * glm::exp(-extinction[k] * range);
  return left;
}

double HazeOptics::sigma_px(double range) const {
  return inner_px + range * std::sqrt(range) * lambda * std::sqrt(scattering);
}

HazeOptics haze_optics(double kappa_a, double kappa_s, double lambda) {
  HazeOptics optics;
  optics.extinction.fill(glm::dvec3{kappa_a + kappa_s});
  optics.scattering = kappa_s;
  optics.lambda = lambda;
  return optics;
}

HazeOptics haze_optics(const AttenuationNodes& nodes, ScatteringModel model, const AirState& air, double altitude_m,
                       double farthest_m, double lambda) {
  const auto haze = haze_coefficients(nodes, model, air);
  const double rayleigh = farthest_m * std::exp(-altitude_m / kRayleighScaleHeight_m);
  const double mie = farthest_m * std::exp(-altitude_m / kMieScaleHeight_m);
  HazeOptics optics;
  optics.weight = haze.weight;
  double green = 0.0;
  for (std::size_t k = 0; k < haze.weight.size(); ++k) {
    optics.extinction[k] = rayleigh * haze.rayleigh_per_m[k] + mie * haze.mie_per_m[k];
    green += haze.weight[k].g * optics.extinction[k].g;
  }
  optics.scattering = green;
  optics.lambda = lambda;
  return optics;
}

BlurMap blur_map(const HazeRange& range, const HazeOptics& optics) {
  BlurMap map;
  map.inner_px = optics.inner_px;
  map.sigma_px = range.range;
  for (float& value : map.sigma_px.elements())
    value = static_cast<float>(std::max(optics.sigma_px(static_cast<double>(value)), optics.inner_px));
  map.steps_along_row = range.steps_along_row;
  map.steps_down_column = range.steps_down_column;
  return map;
}

Image<glm::vec4> attenuated(const Image<glm::vec3>& light, const Image<float>& range, const HazeOptics& optics,
                            const glm::dvec3& airlight) {
  Image<glm::vec4> faded(light.width(), light.height());
  for (std::size_t i = 0; i < faded.elements().size(); ++i) {
    const auto left = optics.transmission(static_cast<double>(range.elements()[i]));
    const double most = std::max({left.r, left.g, left.b});
    faded.elements()[i] =
        glm::vec4(glm::dvec4(left * glm::dvec3(light.elements()[i]) + (most - left) * airlight, most));
  }
  return faded;
}

Image<glm::vec3> composited(const Image<glm::vec4>& blurred, const glm::dvec3& airlight) {
  Image<glm::vec3> light(blurred.width(), blurred.height());
  std::ranges::transform(blurred.elements(), light.elements().begin(), [&](const glm::vec4& f) {
    return glm::max(glm::vec3(f) + (1.0F - f.a) * glm::vec3(airlight), 0.0F);
  });
  return light;
}

Result<HazedImage> under_haze(const Image<glm::vec3>& light, const HazeRange& range, const HazeOptics& optics,
                              const glm::dvec3& airlight, DiffusionScheme scheme) {
  if (range.range.width() != light.width() || range.range.height() != light.height())
    return fail(FaultKind::bad_input, "a range map of {} x {}: expected {} x {}, the size of the picture",
                range.range.width(), range.range.height(), light.width(), light.height());
  const auto map = blur_map(range, optics);
  auto blurred = diffuse(scheme, attenuated(light, range.range, optics, airlight), map);
  if (!blurred) return fail(blurred.error());
  const auto widest = static_cast<double>(*std::ranges::max_element(map.sigma_px.elements()));
  return HazedImage{composited(*blurred, airlight), cost_of(scheme, optics.inner_px, widest)};
}

}  // namespace kasumi
