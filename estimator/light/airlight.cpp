#include "estimator/light/airlight.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <glm/common.hpp>
#include <glm/matrix.hpp>

#include "base/statistics.hpp"

namespace kasumi {
namespace {

// A channel of the model's sky never falls below this share of the sky's luminance: chromaticities at the edge of the
// model (T near 20, sun near the horizon) lie outside the gamut of linear sRGB.
constexpr double kLeastShare = 1e-3;

// The model's sky at a direction in the camera's channels, in units of its zenith luminance.
glm::dvec3 model_light(const SiteSky& model, const Direction& direction, const glm::dmat3& xyz_to_light) {
  const glm::dvec3 xyz = model.relative_xyz(direction);
  const glm::dvec3 light = xyz_to_light * xyz;
  const glm::dvec3 grey = xyz_to_light * glm::dvec3{xyz.y};
  glm::dvec3 safe;
  for (int c = 0; c < 3; ++c) {
    const double least = kLeastShare * std::max(std::abs(grey[c]), 1e-12);
    safe[c] = std::isfinite(light[c]) ? std::max(light[c], least) : least;
  }
  return safe;
}

// M Eq 13's numerator.
double first_perez_factor(const PreethamSky& model, double cos_theta) {
  const PerezCoefficients k = perez_coefficients(PerezQuantity::luminance, model.turbidity());
  return 1.0 + k.a * std::exp(k.b / clamp_cosine(cos_theta));
}

}  // namespace

std::string_view name_of(ZetaForm form) {
  return form == ZetaForm::paper ? "paper" : "full";
}

std::optional<ZetaForm> zeta_form_named(std::string_view name) {
  for (const auto form : {ZetaForm::full, ZetaForm::paper}) {
    if (name == name_of(form)) return form;
  }
  return std::nullopt;
}

glm::dvec3 zeta(ZetaForm form, const SiteSky& model, const Direction& direction, const Direction& reference,
                const glm::dmat3& xyz_to_light) {
  if (const PreethamSky* perez = model.preetham(); perez && form == ZetaForm::paper)
    return glm::dvec3{first_perez_factor(*perez, direction.z) / first_perez_factor(*perez, reference.z)};
  return model_light(model, direction, xyz_to_light) / model_light(model, reference, xyz_to_light);
}

Airlight::Airlight(HorizonLight horizon, const SiteSky& sky, const glm::dmat3& light_to_xyz, ZetaForm form)
    : horizon_(std::move(horizon)), model_(sky), xyz_to_light_(glm::inverse(light_to_xyz)), form_(form) {}

Airlight::Airlight(HorizonLight horizon, Turbidity turbidity, const SunDirection& sun, const glm::dmat3& light_to_xyz,
                   ZetaForm form)
    : Airlight(std::move(horizon), PreethamSky(turbidity, raised_to_horizon(sun)), light_to_xyz, form) {}

glm::dvec3 Airlight::from(const Direction& direction) const {
  const HorizonColumn column = column_at(horizon_, azimuth_angle(direction));
  const Direction reference = direction_from(column.zenith, column.azimuth);
  return glm::max(column.light, glm::dvec3{0.0}) * zeta(form_, model_, direction, reference, xyz_to_light_);
}

}  // namespace kasumi
