// The options of `kasumi sky`, as typed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "calib/camera.hpp"
#include "pipeline/air_options.hpp"
#include "pipeline/lab/sky/dome_drawing.hpp"

namespace kasumi {

struct SkyOptions {
  std::string projection = "perspective", size, utc, model = "dome", out, sheet, day, compare;
  std::vector<double> turbidities, aods, altitudes_m, site;
  AirOptions aerosol;  // exponent and kind
  std::optional<double> sun_zenith_deg, sun_azimuth_deg;
  double field_of_view_deg = 65.0, heading_deg = 0.0, pitch_deg = 12.0, exposure_ev = 0.0, frames_per_second = 12.0;
  int frames = 96;
  bool terrain = false, no_aerial_perspective = false, cpu = false, window = false;
};

// The same, validated.
struct DrawingTask {
  Viewpoint camera;
  DomeRequest sky;                               // of the first turbidity and altitude
  std::vector<double> turbidities, altitudes_m;  // T of the aerosol where it is known
  std::optional<Site> site;
  std::optional<Utc> utc;
  bool mountains = false;
};
// Errors: bad_input, listing every problem.
Result<DrawingTask> sky_task(const SkyOptions& options);

Result<int> run_sky(const SkyOptions& options);

}  // namespace kasumi
