// The parameters of a picture of the sky, from altitude, turbidity and sun.
#pragma once

#include <optional>

#include "base/sky/dome_scene.hpp"
#include "estimator/given_air.hpp"

namespace kasumi {

struct DomeRequest {
  SkyKind kind = SkyKind::dome;
  double altitude_m = 0.0;
  Turbidity turbidity{2.5};
  std::optional<Aerosol> like;  // of a known aerosol: exponent and kind; T says how much of it
  SunDirection sun{0.0, 0.0, 1.0};
  double exposure_ev = 0.0;        // each stop is twice as bright
  std::optional<double> exposure;  // per cd/m2, instead of the sky's own: for comparing skies
  bool sun_disc = true;
  bool aerial_perspective = true;

  Aerosol aerosol() const { return air_of(turbidity, like).aerosol(); }
};

// Per cd/m2. Eyes and cameras adapt incompletely to dusk: a tenth of the loss, in stops, stays visible.
double exposure_for(double mean_luminance);

// Exposed as the eye would: nearly, but not completely, adapted to the mean of the sky. Costs some milliseconds.
DomeScene sky_scene(const DomeRequest& request);

// Light of the sky above the horizon: geometric mean of the luminance, cd/m2, and illuminance on level ground, linear
// sRGB, lux.
struct HemisphereSums {
  double mean_luminance = 0.0;
  glm::dvec3 on_level_ground{0.0};
};
HemisphereSums sky_sums(const DomePainter& painter);

}  // namespace kasumi
