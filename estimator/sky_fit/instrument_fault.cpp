#include "estimator/sky_fit/instrument_fault.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <vector>

#include <fmt/format.h>
#include <glm/exponential.hpp>

#include "estimator/sky_fit/known_skies.hpp"

namespace kasumi {

namespace {

// Bounds the time; below the second number no fault is distinguished from another.
constexpr std::size_t kReadings = 160, kFewest = 30;
constexpr Radians kLensGlare = from_degrees(10.0);  // where a lens scatters the sun's light even without a fault
constexpr double kExplains = 0.7;                   // of the residual left: half of the variance
constexpr double kPrior = 0.5;  // probability of each fault before the picture was looked at, over that of none
// All that are looked for.
constexpr std::array kFaults{InstrumentFault::tone_curve, InstrumentFault::colours, InstrumentFault::vignetting,
                             InstrumentFault::glare};
constexpr glm::dvec3 kThirds{1.0 / 3.0};  // the mean of three channels

// Sums over the readings of what one number beside a gain per colour can and cannot explain.
struct OneNumber {
  double xx = 0.0, xy = 0.0, yy = 0.0;
  int places = 0;
  double residual(double factor) const {
    return std::sqrt(std::max(0.0, yy - 2.0 * factor * xy + factor * factor * xx) / (3.0 * places));
  }
  double best() const { return xx > 0.0 ? xy / xx : 0.0; }
};
// y ~ gain of the colour + factor x
template <class X, class Y>
OneNumber one_number(std::size_t places, const X& x, const Y& y) {
  OneNumber sums;
  sums.places = static_cast<int>(places);
  glm::dvec3 mean_x{0.0}, mean_y{0.0};
  for (std::size_t i = 0; i < places; ++i) mean_x += x(i), mean_y += y(i);
  mean_x /= static_cast<double>(places);
  mean_y /= static_cast<double>(places);
  for (std::size_t i = 0; i < places; ++i) {
    const glm::dvec3 dx = x(i) - mean_x, dy = y(i) - mean_y;
    sums.xx += glm::dot(dx, dx);
    sums.xy += glm::dot(dx, dy);
    sums.yy += glm::dot(dy, dy);
  }
  return sums;
}

// y ~ gain of the colour + a x + b z: what is left.
template <class X, class Z, class Y>
double residual_of_two(std::size_t places, const X& x, const Z& z, const Y& y) {
  const OneNumber by_z = one_number(places, z, y);
  const OneNumber x_by_z = one_number(places, z, x);
  const double along = by_z.best(), turned = x_by_z.best();
  const OneNumber rest = one_number(
      places, [&](std::size_t i) { return x(i) - turned * z(i); }, [&](std::size_t i) { return y(i) - along * z(i); });
  return rest.residual(rest.best());
}

// One hypothesis over all skies: a fault, or none.
class Hypothesis {
 public:
  void add(double amount, double log_residual, double aod_550) {
    if (log_residual < log_residual_) amount_ = amount, log_residual_ = log_residual;
    // The known skies are some percent apart.
    constexpr double kCoarse = 0.01, kIndependentValues = 15.0;
    const double likelihood = std::pow(std::hypot(log_residual, kCoarse), -kIndependentValues);
    likelihood_ += likelihood;
    aod_550_ += likelihood * aod_550;
  }
  double amount() const { return amount_; }
  double log_residual() const { return log_residual_; }
  double likelihood() const { return likelihood_; }
  double aod_550() const { return likelihood_ > 0.0 ? aod_550_ / likelihood_ : 0.0; }

 private:
  double amount_ = 0.0, log_residual_ = std::numeric_limits<double>::infinity();
  double likelihood_ = 0.0, aod_550_ = 0.0;
};

}  // namespace

FaultFinding find_fault(std::span<const SkyReading> all_readings, const SunDirection& sun, double altitude_m) {
  FaultFinding finding;
  std::vector<SkyReading> apart;  // from the sun, where every lens adds light of its own
  std::ranges::copy_if(all_readings, std::back_inserter(apart), [&](const SkyReading& reading) {
    return angle_between(reading.direction, sun).value > kLensGlare.value;
  });
  if (apart.size() < kFewest) return finding;

  const std::vector<SkyReading> readings = thinned(apart, kReadings);
  const std::size_t n = readings.size();
  std::vector<glm::dvec3> read(n);
  glm::dvec3 mean{0.0};
  for (std::size_t i = 0; i < n; ++i) read[i] = glm::log(readings[i].light), mean += readings[i].light;
  mean /= static_cast<double>(n);
  // Without the glare, whose colour is all light's; as much of it as leaves light everywhere.
  struct Cleared {
    double glare;
    std::vector<glm::dvec3> read;
  };
  std::vector<Cleared> cleared;
  for (const double glare : {0.02, 0.04, 0.06, 0.08, 0.11, 0.14, 0.18, 0.22, 0.27, 0.33, 0.4, 0.5}) {
    Cleared without{glare, {}};
    for (const SkyReading& r : readings) {
      const glm::dvec3 rest = r.light - glare * mean;
      if (std::min({rest.r / r.light.r, rest.g / r.light.g, rest.b / r.light.b}) < 0.1) break;
      without.read.push_back(glm::log(rest));
    }
    if (without.read.size() == n) cleared.push_back(std::move(without));
  }

  Hypothesis none;
  std::array<Hypothesis, kFaults.size()> faults;
  auto& [tone_curve, colours, vignetting, glare] = faults;
  double left_by_two = std::numeric_limits<double>::infinity();
  for (const KnownRadiance& sky : known_skies(readings, sun, altitude_m)) {
    const auto light = [&](std::size_t i) { return sky.log_light[i]; };
    const OneNumber tone = one_number(n, light, [&](std::size_t i) { return read[i]; });
    none.add(1.0, tone.residual(1.0), sky.aod_550);
    const double exponent = std::clamp(tone.best(), 0.2, 3.0);
    tone_curve.add(exponent, tone.residual(exponent), sky.aod_550);
    const auto white = [&](std::size_t i) { return glm::dvec3{glm::dot(sky.log_light[i], kThirds)}; };
    const OneNumber chroma = one_number(
        n, [&](std::size_t i) { return light(i) - white(i); }, [&](std::size_t i) { return read[i] - white(i); });
    const double stronger = std::clamp(chroma.best(), 0.1, 3.0);
    colours.add(stronger, chroma.residual(stronger), sky.aod_550);
    const auto towards_edge = [&](std::size_t i) { return glm::dvec3{-readings[i].off_axis * readings[i].off_axis}; };
    const OneNumber loss = one_number(n, towards_edge, [&](std::size_t i) { return read[i] - light(i); });
    const double lost = std::clamp(loss.best(), 0.0, 1.5);
    vignetting.add(-std::expm1(-lost), loss.residual(lost), sky.aod_550);
    left_by_two =
        std::min(left_by_two, residual_of_two(n, light, towards_edge, [&](std::size_t i) { return read[i]; }));
    for (const Cleared& without : cleared)
      glare.add(without.glare / (1.0 - without.glare),
                one_number(n, light, [&](std::size_t i) { return without.read[i]; }).residual(1.0), sky.aod_550);
  }
  finding.log_residual = none.log_residual();
  finding.aod_550 = none.aod_550();
  finding.log_residual_of_two = left_by_two;
  double all = none.likelihood(), shifts = 0.0;
  for (std::size_t k = 0; k < kFaults.size(); ++k) {
    finding.tried[k] = {kFaults[k], faults[k].amount(), faults[k].log_residual(), faults[k].aod_550()};
    const double weight = kPrior * faults[k].likelihood();
    all += weight;
    shifts += weight * std::pow(faults[k].aod_550() - none.aod_550(), 2);
  }
  finding.doubt_of_aod = std::sqrt(shifts / all);
  const FaultExplanation& best = *std::ranges::min_element(finding.tried, {}, &FaultExplanation::log_residual);
  if (best.log_residual < kExplains * finding.log_residual) finding.found = best;
  return finding;
}

namespace {

std::string text_of(const FaultExplanation& fault) {
  switch (fault.fault) {
    case InstrumentFault::tone_curve:
      return fmt::format(
          "the picture's tone curve is not that of its --response: contrasts of a clear sky are raised to the power "
          "{:.2f}",
          fault.amount);
    case InstrumentFault::colours:
      return fmt::format("the camera makes colours {} than they are: to the power {:.2f}",
                         fault.amount < 1.0 ? "weaker" : "stronger", fault.amount);
    case InstrumentFault::vignetting:
      return fmt::format("vignetting: {:.0f} % of the light is lost at the lens' edge", 100.0 * fault.amount);
    case InstrumentFault::glare:
      return fmt::format("glare of the dome or lens: {:.0f} % of the sky's mean light is added everywhere",
                         100.0 * fault.amount);
  }
  return {};
}

}  // namespace

std::string text_of(const FaultFinding& finding) {
  const double percent = 100.0 * finding.log_residual;
  if (!finding.found) {
    if (finding.log_residual_of_two < kExplains * finding.log_residual)
      return fmt::format(
          "tone curve and vignetting are not what is known of the camera: no clear sky is nearer than {:.0f} %, {:.0f} "
          "% with both free",
          percent, 100.0 * finding.log_residual_of_two);
    return fmt::format(
        "no clear sky is nearer than {:.0f} %, and neither tone curve, vignetting, strength of colours nor glare alone "
        "explains it",
        percent);
  }
  constexpr double kAsGood = 1.3;  // in one picture glare and a flat tone curve look nearly the same
  std::string text = text_of(*finding.found);
  for (const FaultExplanation& other : finding.tried)
    if (other.fault != finding.found->fault && other.log_residual < kAsGood * finding.found->log_residual &&
        other.log_residual < kExplains * finding.log_residual)
      text += "; or " + text_of(other);
  return text + fmt::format(" (no clear sky is nearer than {:.0f} %, {:.0f} % with it)", percent,
                            100.0 * finding.found->log_residual);
}

}  // namespace kasumi
