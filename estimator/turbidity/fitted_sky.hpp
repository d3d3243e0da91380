// The clear sky that an estimate fits: Preetham's, or the dome as seen from the site. T belongs to the model
// (docs/sky.md: the two differ); the rest of an estimate is the same for both.
#pragma once

#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "estimator/sky/site_sky.hpp"
#include "estimator/turbidity/dome_log.hpp"
#include "estimator/turbidity/perez_log.hpp"

namespace kasumi {

class FittedSky {
 public:
  FittedSky() = default;  // Preetham's
  FittedSky(const ModelToFit& sky, const SunDirection& sun) {
    if (resolved(sky.model, sky.altitude_m) == DaylightModel::dome) dome_.emplace(sky.altitude_m, sun, sky.aerosol);
  }
  const DomeLog* dome() const { return dome_ ? &*dome_ : nullptr; }  // null: Preetham's
  Turbidity lowest() const { return dome_ ? dome_->lowest() : kLowestTurbidity; }
  Turbidity highest() const { return dome_ ? dome_->highest() : kHighestTurbidity; }

  // ln of luminance, in a unit of the model's own that does not depend on T.
  double log_luminance(Turbidity turbidity, double cos_zenith, double sun_distance) const {
    const double cosine = std::cos(sun_distance);
    if (dome_) return dome_->between(turbidity).value_of(dome_->at(cos_zenith, cosine));
    return PerezLog(turbidity).at({1.0 / clamp_cosine(cos_zenith), sun_distance, cosine * cosine}).log_f;
  }

 private:
  std::optional<DomeLog> dome_;
};

// The same at fixed places for many T, with the derivative.
class FittedPlaces {
 public:
  FittedPlaces(std::span<const LuminanceSample> samples, const FittedSky& sky) {
    if (sky.dome()) {
      log_ = *sky.dome();
      dome_.reserve(samples.size());
      for (const LuminanceSample& s : samples)
        dome_.push_back(log_->at(std::cos(double{s.zenith}), std::cos(double{s.sun_distance})));
    } else {
      perez_.reserve(samples.size());
      for (const LuminanceSample& s : samples) perez_.push_back(perez_point(s));
    }
  }
  // use(i, ln F, d ln F / dT) for every place.
  template <class Use>
  void at(Turbidity turbidity, Use&& use) const {
    const PerezLog perez(turbidity);
    for (std::size_t i = 0; i < perez_.size(); ++i) {
      const auto [log_f, slope] = perez.at(perez_[i]);
      use(i, log_f, slope);
    }
    if (!log_) return;
    const auto between = log_->between(turbidity);
    for (std::size_t i = 0; i < dome_.size(); ++i) use(i, between.value_of(dome_[i]), between.slope_of(dome_[i]));
  }

 private:
  std::optional<DomeLog> log_;
  std::vector<PerezPoint> perez_;  // one of the two
  std::vector<DomeLog::Nodes> dome_;
};

}  // namespace kasumi
