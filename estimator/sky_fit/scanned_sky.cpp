#include "estimator/sky_fit/scanned_sky.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <type_traits>

#include <fmt/format.h>
#include <glm/common.hpp>

#include "base/statistics.hpp"
#include "estimator/sky_fit/model_light.hpp"

namespace kasumi {
namespace {

constexpr std::size_t kFewestAgreeing = 20;   // a quarter of a scan's 81 directions: fewer fit any model
constexpr double kLeastAgreement = 0.40;      // of the directions looked at; as of a picture's samples
constexpr double kClearScan = 0.80;           // from this share on the sky is called clear
constexpr double kLargestLogResidual = 0.16;  // as of pictures; no upper limit on sigma
// A direction is no clear sky when it is off by so many times the others' scatter, and by at least so much of ln Y.
constexpr double kOffSigmas = 3.5, kLeastOff = 0.10;
constexpr int kTurns = 4;  // fit and choice of directions by turns; it ends earlier when the choice stays
// A fit that leaves more may have been drawn away by clouds.
constexpr double kSuspiciousResidual = 0.10;
// A sky that does not depend on the sun, 1 + b cos theta, is overcast if it explains the light better than clear sky.
constexpr std::array kGreySlopes{0.0, 0.5, 1.0, 2.0, 4.0};
constexpr double kBetterGrey = 0.75, kGoodGrey = 0.18;

double luminance_of(const glm::dvec3& linear_srgb) {
  return 0.2126 * linear_srgb.r + 0.7152 * linear_srgb.g + 0.0722 * linear_srgb.b;
}

template <class Values>
auto chosen(const Values& values, const std::vector<std::uint8_t>& used) {
  std::vector<std::remove_cvref_t<decltype(values[0])>> some;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (used[i]) some.push_back(values[i]);
  return some;
}

using LightOf = std::function<glm::dvec3(const Direction&)>;

// ln(measured / model) of luminance and of blue over red, the median of those that are used taken off.
struct ScanResiduals {
  std::vector<double> luminance, colour;
};
void take_median_off(std::vector<double>& residuals, const std::vector<std::uint8_t>& used) {
  const double gain = median(chosen(residuals, used));
  for (double& r : residuals) r -= gain;
}
ScanResiduals scan_residuals(std::span<const SkyReading> readings, const LightOf& model,
                             const std::vector<std::uint8_t>& used) {
  ScanResiduals residuals;
  for (const auto& reading : readings) {
    const auto expected = glm::max(model(reading.direction), glm::dvec3(1e-12));
    residuals.luminance.push_back(std::log(luminance_of(reading.light) / luminance_of(expected)));
    residuals.colour.push_back(std::log(reading.light.b / reading.light.r * expected.r / expected.b));
  }
  take_median_off(residuals.luminance, used);
  take_median_off(residuals.colour, used);
  return residuals;
}

double limit_of(const std::vector<double>& residuals, const std::vector<std::uint8_t>& used) {
  return std::max(kLeastOff, kOffSigmas * robust_sigma(chosen(residuals, used)));
}

std::vector<std::uint8_t> agreeing(const ScanResiduals& residuals, const std::vector<std::uint8_t>& looked_at,
                                   const std::vector<std::uint8_t>& used, bool colours) {
  const double off = limit_of(residuals.luminance, used), off_colour = limit_of(residuals.colour, used);
  auto agrees = looked_at;
  for (std::size_t i = 0; i < agrees.size(); ++i)
    if (std::abs(residuals.luminance[i]) > off || (colours && std::abs(residuals.colour[i]) > off_colour))
      agrees[i] = 0;
  return agrees;
}

double median_size(std::vector<double> residuals) {
  for (double& r : residuals) r = std::abs(r);
  return median_in_place(residuals);
}

// How well the best grey sky explains the readings: median |ln(measured / model)|.
double grey_error(std::span<const SkyReading> readings) {
  const std::vector<std::uint8_t> all(readings.size(), 1);
  double least = 1e9;
  for (const double slope : kGreySlopes)
    least = std::min(
        least, median_size(scan_residuals(
                               readings, [&](const Direction& view) { return glm::dvec3(1.0 + slope * view.z); }, all)
                               .luminance));
  return least;
}

// The model that is followed: of the likeliest family the likeliest.
const ModelFit& followed(const SkyFit& fit) {
  const bool papers = fit.found.papers_share > 0.5;
  const auto of_family = [&](const ModelFit& model) { return papers == (model.answer.name == "preetham"); };
  const auto first = std::find_if(fit.models.begin(), fit.models.end(), of_family);
  return first != fit.models.end() ? *first : fit.models.front();
}

ModelToFit sky_followed(const SkyFit& fit, ModelToFit sky) {
  if (!sky.every_model) return sky;
  const bool papers = fit.found.papers_share > 0.5;
  sky.model = papers ? DaylightModel::preetham : DaylightModel::dome;
  sky.aerosol = papers ? std::nullopt : std::optional(fit.found.aerosol);
  return sky;
}

TurbidityEstimate scan_answer(const SkyFit& fit, const ModelToFit& sky) {
  TurbidityEstimate estimate;
  estimate.turbidity = fit.turbidity;
  estimate.sigma = fit.sigma_turbidity;
  estimate.log_residual = fit.log_residual;
  if (sky.every_model || sky.model != DaylightModel::preetham) estimate.found = fit.found;
  if (fit.models.size() > 1)
    for (const auto& model : fit.models) estimate.models.push_back(model.answer);
  return estimate;
}

double share_of(const std::vector<std::uint8_t>& used, const std::vector<std::uint8_t>& looked_at) {
  return static_cast<double>(std::count(used.begin(), used.end(), 1)) /
         static_cast<double>(std::count(looked_at.begin(), looked_at.end(), 1));
}

std::vector<std::uint8_t> bluest_half(std::span<const SkyReading> readings,
                                      const std::vector<std::uint8_t>& looked_at) {
  const auto blue = [](const SkyReading& reading) { return reading.light.b / reading.light.r; };
  std::vector<double> blues;
  for (const auto& reading : chosen(readings, looked_at)) blues.push_back(blue(reading));
  const double middle = median(blues);
  auto half = looked_at;
  for (std::size_t i = 0; i < half.size(); ++i)
    if (blue(readings[i]) < middle) half[i] = 0;
  return half;
}

// A fit to those readings that agree with it.
struct Fitted {
  SkyFit fit;
  std::vector<std::uint8_t> used;
  double error = 0.0;        // median |ln(measured / model)| of all that were looked at
  std::ptrdiff_t close = 0;  // how many of them lie near the model
};
Fitted fitted_from(std::vector<std::uint8_t> begin, std::span<const SkyReading> readings,
                   const std::vector<std::uint8_t>& looked_at, const SunDirection& sun, const ModelToFit& sky,
                   const InstrumentDoubt& scanner) {
  Fitted result;
  result.used = std::move(begin);
  for (int turn = 0; turn < kTurns; ++turn) {
    result.fit = fit_sky(chosen(readings, result.used), sun, sky, scanner);
    if (!result.fit.solved || result.fit.models.empty()) return result;
    const auto residuals = scan_residuals(readings, light_of(followed(result.fit), sun, sky), result.used);
    result.error = median_size(chosen(residuals.luminance, looked_at));
    result.close = 0;
    for (std::size_t i = 0; i < looked_at.size(); ++i)
      result.close += looked_at[i] && std::abs(residuals.luminance[i]) < kLeastOff &&
                      (!scanner.colours || std::abs(residuals.colour[i]) < kLeastOff);
    auto agrees = agreeing(residuals, looked_at, result.used, scanner.colours);
    if (agrees == result.used) break;
    result.used = std::move(agrees);
    if (static_cast<std::size_t>(std::count(result.used.begin(), result.used.end(), 1)) < kFewestAgreeing) break;
  }
  return result;
}

}  // namespace

ScanEstimate estimate_from_scan(std::span<const SkyReading> readings, const SunDirection& sun, const ModelToFit& sky,
                                const InstrumentDoubt& scanner) {
  ScanEstimate result;
  result.sky = sky;
  result.estimate.sun = sun;
  std::vector<std::uint8_t> looked_at;
  for (const auto& reading : readings)
    looked_at.push_back(angle_between(reading.direction, sun) >= kNearestScanToSun &&
                        reading.direction.z >= std::sin(kLowestScan.value));
  const auto most = static_cast<std::size_t>(std::count(looked_at.begin(), looked_at.end(), 1));
  const auto refused = [&](SkyCondition condition, std::string reason) {
    result.estimate.usable = false;
    result.estimate.sky = condition;
    result.estimate.reason = "rejected: " + std::move(reason);
    return result;
  };
  if (most < kFewestAgreeing)
    return refused(SkyCondition::unknown,
                   fmt::format("{} directions at least {:.0f} deg from the sun and {:.0f} deg high < {}", most,
                               to_degrees(kNearestScanToSun), to_degrees(kLowestScan), kFewestAgreeing));

  Fitted best = fitted_from(looked_at, readings, looked_at, sun, sky, scanner);
  // Clouds may have drawn the fit away from the sky between them, which is bluer.
  if (share_of(best.used, looked_at) < kClearScan || best.fit.log_residual > kSuspiciousResidual) {
    Fitted between = fitted_from(bluest_half(readings, looked_at), readings, looked_at, sun, sky, scanner);
    if (between.close > best.close) best = std::move(between);
  }
  const SkyFit& fit = best.fit;
  const double clear_error = best.error;
  const auto& used = result.used = best.used;
  if (!fit.solved || fit.models.empty()) return refused(SkyCondition::unknown, "no model of the sky could be fitted");
  const auto agree = static_cast<std::size_t>(std::count(used.begin(), used.end(), 1));
  const double share = share_of(used, looked_at);
  result.estimate = scan_answer(fit, sky);
  result.estimate.sun = sun;
  result.sky = sky_followed(fit, sky);
  result.estimate.samples = static_cast<int>(agree);
  result.estimate.clear_fraction = share;

  const double grey = grey_error(chosen(readings, looked_at));
  if (grey < kGoodGrey && grey < kBetterGrey * clear_error)
    return refused(SkyCondition::overcast,
                   fmt::format("overcast: a grey sky fits within {:.1f} %, a clear one within {:.1f} %", 100.0 * grey,
                               100.0 * clear_error));
  if (agree < kFewestAgreeing || share < kLeastAgreement)
    return refused(SkyCondition::unknown, fmt::format("{} of {} directions agree with a clear sky", agree, most));
  if (fit.log_residual > kLargestLogResidual)
    return refused(SkyCondition::unknown,
                   fmt::format("the likeliest clear sky leaves {:.0f} % (rms), {:.0f} % are allowed",
                               100.0 * fit.log_residual, 100.0 * kLargestLogResidual));
  result.estimate.usable = true;
  result.estimate.sky = share >= kClearScan ? SkyCondition::clear : SkyCondition::partly_cloudy;
  return result;
}

}  // namespace kasumi
