// --sky-model: which models of the clear sky an estimate asks.
#pragma once

#include <string>
#include <string_view>

#include "base/result.hpp"
#include "estimator/given_air.hpp"
#include "estimator/sky/site_sky.hpp"

namespace kasumi {

inline constexpr const char* kSkyModelWords =
    "Models of the clear sky to ask: auto, all of them, weighed by how they explain it; preetham, the papers'; dome, "
    "seen from the site's altitude (docs/sky.md); hosek:FILE, with Hosek and Wilkie's data; auto+hosek:FILE, theirs "
    "too";

// `text`: as typed; empty: auto. `given`: of the aerosol, which only the dome knows. Problems: a name that is none of
// these, a file that cannot be read, an aerosol given to a model that has none.
ModelToFit model_to_fit(const std::string& text, double altitude_m, const GivenAir& given, Problems& problems);

// The family of the sky to which an estimate's T belongs: "preetham", "dome" or "hosek".
std::string_view followed_model(const ModelToFit& sky);

}  // namespace kasumi
