// A camera's tone curve from several of its pictures of clear skies. The contrasts of one sky may be the air's; those
// of many, under suns of different height, are explained by clear skies only through the right curve.
#pragma once

#include <span>
#include <vector>

#include "base/result.hpp"
#include "calib/light/radiometry.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/sky_fit/sky_reading.hpp"

namespace kasumi {

struct ToneEvidence {
  std::vector<SkyReading> readings;  // of clear air alone, by the response that was supposed
  SunDirection sun{0.0, 0.0, 1.0};
};

struct ToneCurve {
  double exponent = 1.0;  // d ln(light as read) / d ln(light); 1: the supposed response is right
  double sigma = 0.0;
  double log_residual = 0.0;  // root mean square of ln light that is left
  int pictures = 0;
};

// Pictures whose suns are within three degrees show one sky. Errors (bad_input): fewer than two cloudless skies; they do
// not determine the curve, or no exponent makes clear skies of them.
Result<ToneCurve> find_tone_curve(std::span<const ToneEvidence> pictures, double altitude_m);

// The response that undoes the exponent.
Response corrected(const Response& supposed, double exponent);

}  // namespace kasumi
