// Light from infinity in any direction: the measured horizon extended by the sky model (M Eq 12, 13; physics 5).
#pragma once

#include <optional>
#include <string_view>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "base/geometry.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/horizon/horizon.hpp"
#include "estimator/sky/site_sky.hpp"

namespace kasumi {

// full: F(theta, gamma) / F(theta', gamma') of luminance and chromaticity, converted to the camera's channels. paper: M
// Eq 13, the first Perez factor of the luminance alone, the same for all channels; for a sky other than Perez', full.
enum class ZetaForm { full, paper };
std::string_view name_of(ZetaForm form);
std::optional<ZetaForm> zeta_form_named(std::string_view name);

// Light of the model's sky at `direction` per light at `reference`, channel by channel, so that a camera's gains and
// white balance cancel. xyz_to_light: inverse of Camera::light_to_xyz. Always finite and > 0, for every T (clamped to
// 1.7-20), sun and direction.
glm::dvec3 zeta(ZetaForm form, const SiteSky& model, const Direction& direction, const Direction& reference,
                const glm::dmat3& xyz_to_light);

class Airlight {
 public:
  // light_to_xyz: of the scene camera (Camera::light_to_xyz). The horizon must be usable.
  Airlight(HorizonLight horizon, const SiteSky& sky, const glm::dmat3& light_to_xyz, ZetaForm form = ZetaForm::full);
  // Under Preetham's sky.
  Airlight(HorizonLight horizon, Turbidity turbidity, const SunDirection& sun, const glm::dmat3& light_to_xyz,
           ZetaForm form = ZetaForm::full);
  // Light from infinity towards the observer from `direction` (world), in the scene camera's channels and scale.
  glm::dvec3 from(const Direction& direction) const;

 private:
  HorizonLight horizon_;
  SiteSky model_;
  glm::dmat3 xyz_to_light_;
  ZetaForm form_;
};

}  // namespace kasumi
