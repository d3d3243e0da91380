// The response curve of one camera from several of its pictures of the sky.
#pragma once

#include <filesystem>
#include <optional>
#include <span>

#include "estimator/sky_fit/tone_curve.hpp"
#include "pipeline/lab/photographs/sky_photograph.hpp"

namespace kasumi {

struct DatedFile {
  std::filesystem::path file;
  std::optional<Utc> utc;
};

// The exponent over sRGB. Pictures with clouds are left out. Errors: bad_input (a picture that cannot be read; those of
// find_tone_curve).
Result<ToneCurve> tone_curve_of(std::span<const DatedFile> taken, PhotographSetup options);

}  // namespace kasumi
