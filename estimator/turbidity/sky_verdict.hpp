// Whether an estimate is accepted and, if not, the reason for people, with numbers.
#pragma once

#include <optional>
#include <string>

#include "estimator/sky_fit/instrument_fault.hpp"
#include "estimator/sky_fit/sky_fit.hpp"
#include "estimator/turbidity/clear_air.hpp"
#include "estimator/turbidity/colour_statistics.hpp"
#include "estimator/turbidity/sky_samples.hpp"
#include "estimator/turbidity/turbidity.hpp"

namespace kasumi {

struct Refusal {
  SkyCondition sky = SkyCondition::unknown;
  std::string reason;
};

// From the sun alone: night, sun too low, direction not known.
std::optional<Refusal> refuse_by_sun(const SunDirection& sun, const EstimateParameters& options);

// Statistics of the picture that need no sky model.
struct ExposureStatistics {
  double solid_angle = 0.0;  // [sr] examined: open, high enough, away from the sun
  double saturated = 0.0;    // shares of it
  double dark = 0.0;
  double brightest = 0.0;  // encoded, 0..1: the largest channel near the sun or, as a high quantile, anywhere
  double spread = 0.0;     // of ln Y over large patches of the sky: highest minus lowest
};
ExposureStatistics statistics_of(const SkyPicture& picture, const ElementGeometry& geometry, const ElementLight& sky);

// Dark, covered, under-exposed, over-exposed, no sky to examine.
std::optional<Refusal> refuse_by_light(const ExposureStatistics& statistics, const SunDirection& sun);

// How well two skies explain the same samples: median |residual| of ln Y with free gain.
struct RivalSkies {
  double clear = 0.0;   // the fitted clear sky
  double grey = 0.0;    // depends on elevation but not on the sun, 1 + b cos theta: overcast (b = 2), fog (b small)
  double spread = 0.0;  // standard deviation of ln Y of the fit's inliers: the variation to be explained
};
RivalSkies compare_skies(std::span<const LuminanceSample> samples, const TurbiditySolution& fit,
                         const FittedSky& sky = {});

// After the fit. `mask_clear`: the share of the sky left by the cloud mask; `brightest`: from ExposureStatistics.
std::optional<Refusal> refuse_by_fit(const TurbiditySolution& fit, int drawn, double mask_clear, double brightest,
                                     const RivalSkies& rivals, const EstimateParameters& options);

// Refusals before any fit: a lens that is covered, or a sky without colour. `brightest`: from ExposureStatistics.
std::optional<Refusal> refuse_by_look(const ColourStatistics& look, double brightest);

// Where an aerosol depth excludes neither clear air nor thick haze, it says nothing.
std::optional<Refusal> refuse_by_sigma(double aod_550, double sigma_aod_550);

// All that a verdict goes by where every model of the sky was asked.
struct VerdictEvidence {
  ColourStatistics look;
  ExposureStatistics statistics;
  ClearAir air;  // by the sky's own form, in the last round
  SkyFit fit;
  int readings = 0;     // the fit's
  int agreeing = 0;     // of them, with the followed sky's luminance
  double bluest = 0.0;  // ln R/B of the bluest tenth of the sky that was examined
  RivalSkies rivals;    // the followed sky and a grey one
  FaultFinding fault;   // of the camera; looked for where no sky is near
};
constexpr double kNearSky = 0.03;  // residual of a fit up to which no fault is looked for
std::optional<Refusal> refuse_by_evidence(const VerdictEvidence& evidence, const EstimateParameters& options);

}  // namespace kasumi
