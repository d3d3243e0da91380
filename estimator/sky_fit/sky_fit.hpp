// From the light of a clear sky to the aerosol above: luminance and colour under every model of the sky, each weighed by
// how well it explains the readings.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "estimator/atmosphere.hpp"
#include "estimator/given_air.hpp"
#include "estimator/sky/site_sky.hpp"
#include "estimator/sky_fit/sky_reading.hpp"

namespace kasumi {

// What is not known of the instrument, as standard deviations. The overall gain is always free.
struct InstrumentDoubt {
  bool colours = true;         // false: a luminance alone
  double white_balance = 0.1;  // of ln(R/G) and ln(B/G)
  double vignetting = 0.0;     // of ln light at the lens' edge; 0: it is known
};

// One model's best sky.
struct ModelFit {
  ModelAnswer answer;
  std::optional<AerosolKind> kind;  // of the dome's
  Aerosol aerosol;                  // exponent and kind as the model supposes where it cannot know
  AerosolCovariance covariance;     // under this model
  double sigma_turbidity = 0.0;     // under this model
  double log_luminance_gain = 0.0;  // ln(measured Y / the model's), for a plot
  double ground_albedo = 0.2;       // as the readings have it; a dome supposes .2
  bool at_edge = false;             // of the model's range
};

struct SkyFit {
  bool solved = false;  // false: too few readings
  FoundAerosol found;   // over all models
  Turbidity turbidity;
  double sigma_turbidity = 0.0;
  double log_residual = 0.0;     // of the likeliest model
  std::vector<ModelFit> models;  // the likeliest first; the likeliest blend has the weight of all
};

// `readings`: of clear sky alone, some hundred. `sky`: which models, the site's altitude, what is given. Domes are asked
// by kind and by blends of two; `found.covariance` holds what no dome knows of other particles (docs/sky.md).
SkyFit fit_sky(std::span<const SkyReading> readings, const SunDirection& sun, const ModelToFit& sky,
               const InstrumentDoubt& doubt);

}  // namespace kasumi
