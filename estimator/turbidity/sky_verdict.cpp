#include "estimator/turbidity/sky_verdict.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#include "base/statistics.hpp"
#include "estimator/nth_smallest.hpp"
#include "estimator/turbidity/perez_log.hpp"

namespace kasumi {

namespace {

constexpr double kNightElevationDeg = -6.0;  // the end of civil twilight
constexpr double kMostlyDark = 0.6;          // of the open sky: more is dusk, under-exposure or a covered lens
// Of the open sky: what is left would be the part farthest from the sun alone.
constexpr double kMostlySaturated = 0.5;
constexpr double kUniform = 0.10;  // of ln Y: even fog varies more from the horizon to the zenith
constexpr double kBetter = 0.75;   // of the clear sky's error: then it is a grey sky ...
constexpr double kGreySky = 0.18;  // ... if it fits well enough ...
constexpr double kGoodFit = 0.02;  // ... and the clear sky is no good
// Residual over the variation to be explained. A whitish sky must fit better: no blue distinguishes it from a cloud.
constexpr double kWhitish = 8.0;
constexpr double kUnexplained = 0.40, kUnexplainedWhitish = 0.20;
constexpr double kSunVisible = 0.5;  // encoded: the least for the brightest part of the picture

// Of a sky's look: ln R/B of clear air varies by more, or its bluest part is bluer.
constexpr double kColourless = 0.25, kBlue = -0.35;
constexpr double kRed = 0.2;                     // redder than any cloud by day: what shines through cloth or skin
constexpr double kSmooth = 0.85, kUneven = 0.5;  // shares that agree with one smooth sky: surely clear air; not at all
constexpr double kBroken = 0.5, kMostlyCovered = 0.8;
constexpr double kGapsFit = 0.06;    // of ln light
constexpr double kFaultTold = 0.11;  // of ln light: what is nearer is used, with the doubt of the camera in its sigma

// Median |ln Y - ln F - ln k|, ln k being the median of ln Y - ln F.
double median_error(std::vector<double> residuals) {
  const double gain = median_in_place(residuals);
  for (double& r : residuals) r = std::abs(r - gain);
  return median_in_place(residuals);
}

Refusal refusal(SkyCondition sky, std::string reason) {
  return {sky, "rejected: " + std::move(reason)};
}

// Clear or partly cloudy, a sky is brightest around the sun, where no exposure that shows the rest leaves it dull.
Refusal dull(double brightest) {
  return refusal(SkyCondition::covered_lens,
                 fmt::format("dull: nothing is brighter than {:.0f} % of full scale, not even around the sun: lens "
                             "covered, or exposed far too short",
                             100.0 * brightest));
}

}  // namespace

std::optional<Refusal> refuse_by_sun(const SunDirection& sun, const EstimateParameters& options) {
  if (!std::isfinite(sun.x) || !std::isfinite(sun.y) || !std::isfinite(sun.z) ||
      std::abs(glm::length(sun) - 1.0) > 1e-3)
    return refusal(SkyCondition::unknown, "the sun's direction is unknown");
  const double elevation = 90.0 - to_degrees(zenith_angle(sun));
  if (elevation < kNightElevationDeg)
    return refusal(SkyCondition::night, fmt::format("night: the sun is {:.1f} deg below the horizon", -elevation));
  const double lowest = to_degrees(options.lowest_sun);
  if (elevation < lowest)
    return refusal(SkyCondition::sun_too_low,
                   fmt::format("sun too low: elevation {:.1f} deg < {:.1f} deg", elevation, lowest));
  return std::nullopt;
}

ExposureStatistics statistics_of(const SkyPicture& picture, const ElementGeometry& geometry, const ElementLight& sky) {
  ExposureStatistics statistics;
  std::array<std::vector<float>, ElementGeometry::kRings * ElementGeometry::kSectors> patches;
  std::vector<float> levels;
  levels.reserve(sky.use.elements().size());
  for (std::size_t i = 0; i < sky.use.elements().size(); ++i) {
    if (geometry.open.elements()[i] == 0) continue;
    const glm::vec3& encoded = picture.encoded.elements()[i];
    levels.push_back(std::max({encoded.r, encoded.g, encoded.b}));
    const PixelUse use = sky.use.elements()[i];
    if (use == PixelUse::near_sun)
      statistics.brightest = std::max(statistics.brightest, static_cast<double>(levels.back()));
    if (use == PixelUse::outside || use == PixelUse::near_sun) continue;
    const auto angle = static_cast<double>(geometry.solid_angle.elements()[i]);
    statistics.solid_angle += angle;
    if (use == PixelUse::saturated) statistics.saturated += angle;
    if (use == PixelUse::dark) statistics.dark += angle;
    if (use == PixelUse::saturated || use == PixelUse::dark) continue;
    patches[geometry.patch.elements()[i]].push_back(sky.log_luminance.elements()[i]);
  }
  if (statistics.solid_angle > 0.0) {
    statistics.saturated /= statistics.solid_angle;
    statistics.dark /= statistics.solid_angle;
  }
  statistics.brightest = std::max(statistics.brightest, static_cast<double>(counted_quantile(levels, 0.9995)));
  float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
  for (const std::vector<float>& patch : patches) {
    if (patch.size() < 20) continue;
    const float level = counted_median(patch);
    lowest = std::min(lowest, level);
    highest = std::max(highest, level);
  }
  statistics.spread = highest > lowest ? static_cast<double>(highest - lowest) : 0.0;
  return statistics;
}

std::optional<Refusal> refuse_by_light(const ExposureStatistics& s, const SunDirection& sun) {
  const double elevation = 90.0 - to_degrees(zenith_angle(sun));
  if (!(s.solid_angle > 0.05))
    return refusal(SkyCondition::unknown,
                   fmt::format("the camera sees {:.2f} sr of open sky away from the sun", s.solid_angle));
  if (s.dark > kMostlyDark) {
    if (s.brightest > kSunVisible)
      return refusal(SkyCondition::unknown,
                     fmt::format("under-exposed: {:.0f} % of the sky is black or nearly so", 100.0 * s.dark));
    return refusal(SkyCondition::covered_lens,
                   fmt::format("dark all over ({:.0f} % of the sky is black) while the sun is {:.0f} deg high: lens "
                               "covered, or the clock is wrong",
                               100.0 * s.dark, elevation));
  }
  if (s.saturated > kMostlySaturated)
    return refusal(SkyCondition::unknown,
                   fmt::format("over-exposed: {:.0f} % of the sky is saturated", 100.0 * s.saturated));
  if (s.spread < kUniform)
    return refusal(SkyCondition::covered_lens,
                   fmt::format("uniform: brightness varies by {:.1f} % over the whole sky: lens covered, or dense fog",
                               100.0 * std::expm1(s.spread)));
  return std::nullopt;
}

RivalSkies compare_skies(std::span<const LuminanceSample> samples, const TurbiditySolution& fit, const FittedSky& sky) {
  if (samples.empty()) return {};
  std::vector<double> residuals(samples.size());
  const auto log_y = [&](std::size_t i) { return static_cast<double>(samples[i].log_luminance); };
  FittedPlaces(samples, sky).at(fit.turbidity, [&](std::size_t i, double log_f, double) {
    residuals[i] = log_y(i) - log_f;
  });
  RivalSkies rivals{median_error(residuals), std::numeric_limits<double>::infinity(), 0.0};
  for (const double b : {-0.7, -0.5, -0.3, 0.0, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0}) {
    for (std::size_t i = 0; i < samples.size(); ++i)
      residuals[i] = log_y(i) - std::log1p(b * std::cos(static_cast<double>(samples[i].zenith)));
    rivals.grey = std::min(rivals.grey, median_error(residuals));
  }
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (fit.inlier[i] == 0) continue;
    sum += log_y(i);
    squares += log_y(i) * log_y(i);
  }
  const double n = std::max(1, fit.inliers);
  rivals.spread = std::sqrt(std::max(0.0, squares / n - (sum / n) * (sum / n)));
  return rivals;
}

std::optional<Refusal> refuse_by_fit(const TurbiditySolution& fit, int drawn, double mask_clear, double brightest,
                                     const RivalSkies& rivals, const EstimateParameters& options) {
  const double agreement = drawn > 0 ? static_cast<double>(fit.inliers) / drawn : 0.0;
  const double clouds = 100.0 * (1.0 - mask_clear);
  // A dome fits a cloth worse than a grey sky does.
  const bool papers = !options.sky.every_model && resolved(options.sky.model, options.sky.altitude_m,
                                                           options.sky.aerosol.has_value()) == DaylightModel::preetham;
  if (brightest < kSunVisible && !papers) return dull(brightest);
  // A sky that depends on elevation but not on the sun explains the picture better than any clear sky.
  if (drawn > 0 && rivals.clear > kGoodFit && rivals.grey < kGreySky && rivals.grey < kBetter * rivals.clear)
    return refusal(
        SkyCondition::overcast,
        fmt::format("overcast or fog: brightness depends on elevation alone within {:.1f} %, the best clear sky "
                    "within {:.1f} %",
                    100.0 * rivals.grey, 100.0 * rivals.clear));
  if (brightest < kSunVisible) return dull(brightest);
  if (mask_clear < options.least_clear_fraction)
    return refusal(SkyCondition::overcast,
                   fmt::format("clear sky {:.0f} % < {:.0f} % (clouds {:.0f} %)", 100.0 * mask_clear,
                               100.0 * options.least_clear_fraction, clouds));
  if (fit.inliers < std::min(options.least_samples, options.samples / 2))
    return refusal(mask_clear < 0.5 ? SkyCondition::overcast : SkyCondition::unknown,
                   fmt::format("{} clear samples < {} (clouds {:.0f} %)", fit.inliers,
                               std::min(options.least_samples, options.samples / 2), clouds));
  if (!fit.solved) return refusal(SkyCondition::unknown, "the clear samples do not determine the turbidity");
  if (agreement < options.least_agreement)
    return refusal(
        mask_clear < 0.5 ? SkyCondition::overcast : SkyCondition::unknown,
        fmt::format("only {:.0f} % of the samples agree on a clear sky (at least {:.0f} % must; clouds {:.0f} %)",
                    100.0 * agreement, 100.0 * options.least_agreement, clouds));
  const bool whitish = fit.turbidity.value > kWhitish;
  if (fit.log_residual > options.largest_log_residual)
    return refusal(whitish ? SkyCondition::overcast : SkyCondition::unknown,
                   fmt::format("the best clear sky (T {:.2f}) is off by {:.1f} % > {:.0f} %", fit.turbidity.value,
                               100.0 * fit.log_residual, 100.0 * options.largest_log_residual));
  const double unexplained = fit.log_residual / std::max(1e-9, rivals.spread);
  const double most_unexplained = whitish ? kUnexplainedWhitish : kUnexplained;
  if (fit.log_residual > kGoodFit && unexplained > most_unexplained)
    return refusal(
        whitish ? SkyCondition::overcast : SkyCondition::unknown,
        fmt::format("the best clear sky (T {:.2f}) leaves {:.0f} % of the sky's variation unexplained > {:.0f} %",
                    fit.turbidity.value, 100.0 * unexplained, 100.0 * most_unexplained));
  if (fit.at_edge)
    return refusal(SkyCondition::unknown,
                   fmt::format("the best T is the end of the sky model's range, {:.1f}", fit.turbidity.value));
  if (fit.sigma > options.largest_relative_sigma * fit.turbidity.value)
    return refusal(SkyCondition::unknown, fmt::format("T {:.2f} is uncertain by {:.2f} > {:.0f} %", fit.turbidity.value,
                                                      fit.sigma, 100.0 * options.largest_relative_sigma));
  return std::nullopt;
}

std::optional<Refusal> refuse_by_sigma(double aod_550, double sigma_aod_550) {
  constexpr double kThickHaze = 1.0;  // of optical depth at 550 nm: hills some kilometres away are gone
  if (sigma_aod_550 <= aod_550 || aod_550 + 2.0 * sigma_aod_550 <= kThickHaze) return std::nullopt;
  return refusal(
      SkyCondition::unknown,
      fmt::format("the aerosol depth {:.2f} is uncertain by {:.2f}, so that this may be clear air or thick haze",
                  aod_550, sigma_aod_550));
}

std::optional<Refusal> refuse_by_look(const ColourStatistics& look, double brightest) {
  if (look.places < kFewestPlaces || look.colour_span > kColourless || look.bluest < kBlue) return std::nullopt;
  if (brightest < kSunVisible && look.bluest > kRed)
    return refusal(SkyCondition::covered_lens,
                   fmt::format("dull and red: nothing is brighter than {:.0f} % of full scale, and red over blue is at "
                               "least {:.2f}: lens covered",
                               100.0 * brightest, std::exp(look.bluest)));
  const double span = 100.0 * std::expm1(look.colour_span), least = 100.0 * std::expm1(kColourless);
  // Clouds hide the sun, or are uneven; haze, glare and automatic white balance do neither.
  if (look.sun_seen && look.smooth > kSmooth)
    return refusal(SkyCondition::unknown,
                   fmt::format("washed out: the sun is seen, but red over blue varies by {:.0f} % over the sky (clear "
                               "air's by more than {:.0f} %): glare of the dome or lens, weak colours, or dense haze",
                               span, least));
  return refusal(
      SkyCondition::overcast,
      fmt::format("overcast: the sky is grey all over (red over blue varies by {:.0f} %, clear air's by more "
                  "than {:.0f} %)",
                  span, least));
}

namespace {

// What shows between clouds is used where it is a clear sky beyond doubt.
std::optional<Refusal> refuse_broken_clouds(const ColourStatistics& look, const SkyFit& gaps) {
  if (look.places < kFewestPlaces || (gaps.solved && gaps.log_residual < kGapsFit)) return std::nullopt;
  const SkyCondition sky = look.cover > kMostlyCovered ? SkyCondition::overcast : SkyCondition::partly_cloudy;
  if (look.cover > kBroken)
    return refusal(sky, fmt::format("broken clouds cover {:.0f} % of the sky", 100.0 * look.cover));
  if (look.smooth < kUneven)
    return refusal(sky, fmt::format("clouds: only {:.0f} % of the sky is as smooth as clear air", 100.0 * look.smooth));
  return std::nullopt;
}

// A cloudless sky that no model explains: what of the camera does.
std::optional<Refusal> refuse_by_fault(const FaultFinding& fault, const SkyFit& fit,
                                       const EstimateParameters& options) {
  const bool known = fault.found && fault.log_residual > kFaultTold;
  if (!known && !(std::max(fault.log_residual, fit.log_residual) > options.largest_log_residual)) return std::nullopt;
  return refusal(SkyCondition::unknown, text_of(fault));
}

}  // namespace

std::optional<Refusal> refuse_by_evidence(const VerdictEvidence& evidence, const EstimateParameters& options) {
  if (evidence.statistics.brightest < kSunVisible) return dull(evidence.statistics.brightest);
  if (auto refused = refuse_broken_clouds(evidence.look, evidence.fit)) return refused;
  if (evidence.fit.solved)
    if (auto refused = refuse_by_fault(evidence.fault, evidence.fit, options)) return refused;
  TurbiditySolution fit;
  fit.solved = evidence.fit.solved;
  fit.turbidity = evidence.fit.turbidity;
  fit.sigma = evidence.fit.sigma_turbidity;
  fit.log_residual = evidence.fit.log_residual;
  fit.inliers = evidence.agreeing;
  // An honest large sigma is better than no answer.
  EstimateParameters wide = options;
  wide.largest_relative_sigma = std::numeric_limits<double>::infinity();
  if (auto refused = refuse_by_fit(fit, evidence.readings, evidence.air.clear_fraction, evidence.statistics.brightest,
                                   evidence.rivals, wide)) {
    if (refused->sky == SkyCondition::unknown && fit.solved && evidence.fault.found)
      return refusal(SkyCondition::unknown, text_of(evidence.fault));
    return refused;
  }
  if (fit.turbidity.value > kWhitish && evidence.look.sun_hidden)
    return refusal(SkyCondition::overcast,
                   fmt::format("overcast: no sun is seen through what would be haze of T {:.1f}", fit.turbidity.value));
  return std::nullopt;
}

}  // namespace kasumi
