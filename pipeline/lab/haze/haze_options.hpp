// The options of `kasumi haze`, and the task they describe once checked.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/camera.hpp"
#include "estimator/haze/haze_picture.hpp"
#include "pipeline/air_options.hpp"
#include "pipeline/lab/haze/distance_options.hpp"
#include "pipeline/site/files/photograph_file.hpp"

namespace kasumi {

struct HazeOptions {
  std::string picture, sensitivity, scattering = "auto", scheme = "matched";
  DistanceOptions distances;
  double altitude_m = 0.0, field_of_view_deg = 50.0, pitch_deg = 0.0;
  RangeRules range;
  std::optional<int> outline_reach_px;  // left out: a hundredth of the picture's width
  bool indoors = false, allow_damaged = false;
  bool cut_outlines = false;                                // no light crosses an outline
  std::vector<std::string> turbidities, aods, scatterings;  // numbers, or FROM:TO:STEP
  AirOptions aerosol;                                       // exponent and kind
  std::optional<double> kappa_a;
  double lambda = 15.0;
  std::vector<double> airlight;  // empty: measured
};

// The haze of one picture: of a turbidity, or of H's coefficients per farthest range.
struct HazeValues {
  std::optional<Turbidity> turbidity;
  double kappa_a = 0.0, kappa_s = 0.0;  // without a turbidity
  double lambda = 15.0;
  std::optional<Aerosol> like = std::nullopt;  // of a known aerosol: exponent and kind; T says how much of it
  std::string name() const;                    // "T4.00", "AOD0.300", "a0.25-s0.25": for files and sheets
};

struct HazeTask {
  Camera camera;
  Photograph photograph;
  Image<glm::vec3> light;  // linear
  HazeRange range;
  glm::dvec3 airlight{1.0};
  std::vector<HazeValues> values;  // at least one
  DiffusionScheme scheme = DiffusionScheme::matched;
  ScatteringModel scattering = ScatteringModel::morales2017;  // of all values
  double altitude_m = 0.0;
  AttenuationNodes nodes;
  HazeOptics optics_of(const HazeValues& haze) const;
};

// Errors: bad_input, listing every problem.
Result<HazeTask> haze_task(const HazeOptions& options);

}  // namespace kasumi
