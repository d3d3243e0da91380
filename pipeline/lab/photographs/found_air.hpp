// The state of the air that an estimate has found.
#pragma once

#include <optional>

#include "estimator/atmosphere.hpp"
#include "estimator/sky/site_sky.hpp"

namespace kasumi {

// `estimate`: a usable one. `followed`: the model to which its T belongs.
AirState found_air(const TurbidityEstimate& estimate, const ModelToFit& followed);

struct AerosolSigmas {
  double aod_550 = 0.0;
  std::optional<double> angstrom_exponent;  // empty: nothing is known of the exponent
};
AerosolSigmas aerosol_sigmas(const TurbidityEstimate& estimate, const AirState& air);

}  // namespace kasumi
