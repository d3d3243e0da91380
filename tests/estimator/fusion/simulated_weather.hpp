// Days of air that drift at random, and observers whose errors last.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <random>

#include "estimator/air/scattering.hpp"
#include "estimator/fusion/air_quantities.hpp"
#include "estimator/fusion/air_tracker.hpp"

namespace kasumi::test {

// Three quantities of the air as they are: ln(aod + small), exponent, ln of the path's over the column's.
struct TrueAir {
  double amount = 0.0, exponent = 1.3, near_ground = 0.0;

  double aod() const { return std::max(0.0, std::exp(amount) - kSmallAerosol); }
  double path_amount() const { return amount + near_ground; }
  double path_aod() const { return std::max(0.0, std::exp(path_amount()) - kSmallAerosol); }
};

// An Ornstein-Uhlenbeck process of unit variance.
class Wandering {
 public:
  explicit Wandering(std::mt19937_64& random) : value_(std::normal_distribution<>()(random)) {}
  double value() const { return value_; }
  void step(double seconds, double memory_s, std::mt19937_64& random) {
    const double kept = std::exp(-seconds / memory_s);
    value_ = kept * value_ + std::sqrt(1.0 - kept * kept) * std::normal_distribution<>()(random);
  }

 private:
  double value_;
};

// How an observer errs: so much of its variance lasts so long, in units of the sigma it states.
struct Erring {
  double lasting_share = 0.9;
  double memory_s = 6 * 3600.0;
};

class Observer {
 public:
  Observer(Erring erring, std::mt19937_64& random)
      : erring_(erring), lasting_{Wandering(random), Wandering(random), Wandering(random), Wandering(random)} {}
  void step(double seconds, std::mt19937_64& random) {
    for (auto& one : lasting_) one.step(seconds, erring_.memory_s, random);
  }
  double error(std::size_t of, std::mt19937_64& random) const {
    return std::sqrt(erring_.lasting_share) * lasting_[of].value() +
           std::sqrt(1.0 - erring_.lasting_share) * std::normal_distribution<>()(random);
  }
  double lasting(std::size_t of) const { return lasting_[of].value(); }

 private:
  Erring erring_;
  std::array<Wandering, 4> lasting_;
};

inline ColumnReading column_reading(double aod, double sigma_aod, double exponent, double sigma_exponent,
                                    AirObserver by = AirObserver::sky) {
  ColumnReading reading;
  reading.by = by;
  reading.found.aerosol = {std::max(0.0, aod), exponent, AerosolKind::continental};
  reading.found.covariance = {sigma_aod * sigma_aod, 0.0, sigma_exponent * sigma_exponent};
  reading.found.kinds = {0.7, 0.1, 0.1, 0.025, 0.025, 0.025, 0.025};
  return reading;
}

constexpr std::array<double, 3> kChannels_nm{610.0, 540.0, 465.0};

// Extinction of an amount of aerosol over a path at sea level.
inline double extinction_per_m(double path_aod, double exponent, double wavelength_nm) {
  return rayleigh_per_m(ScatteringModel::aerosol, wavelength_nm) +
         path_aod * std::pow(wavelength_nm / 550.0, -exponent) / kAerosolHeight_m;
}

// `error`: of each channel in its own sigma, and the common one's last.
inline PathReading path_reading(double path_aod, double exponent, double relative_sigma, double shared_sigma,
                                const std::array<double, 4>& error = {}) {
  PathReading reading;
  reading.shared_sigma = shared_sigma;
  for (std::size_t c = 0; c < 3; ++c) {
    const double truly = extinction_per_m(path_aod, exponent, kChannels_nm[c]);
    const double sigma = relative_sigma * truly;
    reading.channels[c] = {PathReading::Channel::Kind::value, kChannels_nm[c],
                           truly * std::exp(shared_sigma * error[3]) + sigma * error[c], sigma};
  }
  return reading;
}

}  // namespace kasumi::test
