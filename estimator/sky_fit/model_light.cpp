#include "estimator/sky_fit/model_light.hpp"

#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/dome.hpp"
#include "estimator/sky/hosek.hpp"
#include "estimator/sky/preetham.hpp"

namespace kasumi {

std::function<glm::dvec3(const Direction&)> light_of(const ModelFit& model, const SunDirection& sun,
                                                     const ModelToFit& sky) {
  if (model.kind)
    return [dome = in_space(dome(sky.altitude_m, model.aerosol, sun), glm::inverse(srgb_to_xyz()))](
               const Direction& view) { return dome_light(dome, view); };
  if (model.answer.name == "hosek" && sky.hosek)
    return [hosek = sky.hosek->sky(model.answer.turbidity, kHosekGroundAlbedo, sun)](const Direction& view) {
      return hosek.linear_srgb(view);
    };
  return [preetham = PreethamSky(model.answer.turbidity, sun), to_srgb = glm::inverse(srgb_to_xyz())](
             const Direction& view) { return to_srgb * preetham.relative_xyz(view); };
}

}  // namespace kasumi
