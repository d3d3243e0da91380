// The options of `kasumi retarget`, and the task they describe.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "estimator/photograph/other_air.hpp"
#include "pipeline/air_options.hpp"
#include "pipeline/lab/haze/distance_options.hpp"

namespace kasumi {

struct RetargetRequest {
  std::vector<std::string> pictures, turbidities, aods;
  std::string camera, planes, sky, sky_model, utc, target_picture, scattering = "auto", out, sheet, film;
  AirOptions aerosol;  // exponent and kind, of source and targets alike
  DistanceOptions distances;
  std::optional<double> distance_m, source_turbidity, source_aod, sun_zenith_deg, sun_azimuth_deg, frames_per_second;
  double field_of_view_deg = 50.0, pitch_deg = 0.0, altitude_m = 0.0;
  double largest_gain = RetargetLimits{}.largest_gain;
  std::vector<double> airlight, target_airlight;
  bool keep_reflectance = false, amplify_noise = false, same_exposure = false, from_haze = false, allow_damaged = false,
       terms = false;
};

struct RetargetTask {
  SourceConditions setup;
  std::vector<std::optional<AirState>> targets;  // nothing: clear
  std::vector<std::string> target_names;         // "T2.50", "AOD0.300", "clear": as they were asked for
};

// `first`: the first picture; all have its size. Where the haze's exponent is not given, it is estimated from that
// picture, and the result is printed. Errors (bad_input): every problem; no turbidity from the picture of the sky.
Result<RetargetTask> retarget_task(const RetargetRequest& arguments, const Photograph& first);

}  // namespace kasumi
