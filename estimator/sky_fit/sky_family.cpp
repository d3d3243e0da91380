#include "estimator/sky_fit/sky_family.hpp"

#include <algorithm>
#include <cmath>

#include <glm/exponential.hpp>

#include "base/sky/dome_terms.hpp"
#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/hosek.hpp"

namespace kasumi {
namespace {

constexpr double kDarkestLight = 1e-7;  // of any unit here; no daytime sky is as dark
constexpr int kDomeNodes = 19, kTurbidityNodes = 25;
// The dome is tabulated over ln(aod + .05): with as much aerosol its light equals the molecules', roughly.
constexpr double kDomeShift = 0.05;
constexpr double kHosekGround = 0.2;

DomeFunction dome_in_srgb(double altitude_m, const Aerosol& aerosol, const SunDirection& sun) {
  return in_space(dome(altitude_m, aerosol, sun), xyz_to_linear_srgb());
}

}  // namespace

CubicTaps cubic_taps(double place, int nodes) {
  const double at = std::clamp(place, 0.0, nodes - 1.0);
  const int left = std::min(static_cast<int>(at), nodes - 2);
  const double u = at - left, u2 = u * u, u3 = u2 * u;
  // Hermite's cubic with slopes by the neighbours; beyond an end the last parabola goes on.
  std::array<double, 4> v{0.5 * (2.0 * u2 - u - u3), 0.5 * (2.0 - 5.0 * u2 + 3.0 * u3), 0.5 * (u + 4.0 * u2 - 3.0 * u3),
                          0.5 * (u3 - u2)};
  std::array<double, 4> s{0.5 * (4.0 * u - 1.0 - 3.0 * u2), 0.5 * (9.0 * u2 - 10.0 * u),
                          0.5 * (1.0 + 8.0 * u - 9.0 * u2), 0.5 * (3.0 * u2 - 2.0 * u)};
  const auto folded_low = [](const std::array<double, 4>& w) {
    return std::array<double, 4>{w[1] + 3.0 * w[0], w[2] - 3.0 * w[0], w[3] + w[0], 0.0};
  };
  const auto folded_high = [](const std::array<double, 4>& w) {
    return std::array<double, 4>{0.0, w[0] + w[3], w[1] - 3.0 * w[3], w[2] + 3.0 * w[3]};
  };
  if (left == 0) return {0, folded_low(v), folded_low(s)};
  if (left == nodes - 2) return {nodes - 4, folded_high(v), folded_high(s)};
  return {left - 1, v, s};
}

SkyFamily SkyFamily::preetham(const SunDirection& sun) {
  SkyFamily family(Form::preetham, sun);
  family.nodes_ = kTurbidityNodes;
  family.first_ = std::log(kLowestTurbidity.value);
  family.step_ = (std::log(kHighestTurbidity.value) - family.first_) / (kTurbidityNodes - 1);
  return family;
}

SkyFamily SkyFamily::dome(AerosolKind kind, double altitude_m, const SunDirection& sun) {
  SkyFamily family(Form::dome, sun);
  family.kind_ = kind;
  family.altitude_m_ = altitude_m;
  family.nodes_ = kDomeNodes;
  family.shift_ = kDomeShift;
  family.first_ = std::log(kDomeShift);
  family.step_ = (std::log(kHighestDomeAod + kDomeShift) - family.first_) / (kDomeNodes - 1);
  const Aerosol some{0.15, kasumi::natural_exponent(kind), kind};
  const DomeFunction sky = dome_in_srgb(altitude_m, some, sun);
  family.on_ground_ =
      light_on_ground([&](const Direction& view) { return dome_light(sky, view); },
                      xyz_to_linear_srgb() * glm::dvec3(dome_sun(altitude_m, some, sun).illuminance), sun);
  return family;
}

SkyFamily SkyFamily::hosek(std::shared_ptr<const HosekSky> sky, const SunDirection& sun) {
  SkyFamily family(Form::hosek, sun);
  family.hosek_ = std::move(sky);
  family.nodes_ = kTurbidityNodes;
  family.first_ = std::log(HosekSky::kLowest.value);
  family.step_ = (std::log(HosekSky::kHighest.value) - family.first_) / (kTurbidityNodes - 1);
  return family;
}

std::string SkyFamily::name() const {
  if (form_ == Form::preetham) return "preetham";
  return form_ == Form::hosek ? "hosek" : "dome, " + std::string(name_of(*kind_));
}

double SkyFamily::amount_at(double place) const {
  return std::max(0.0, std::exp(first_ + step_ * place) - shift_);
}

Aerosol SkyFamily::aerosol_at(const SkyAmount& amount) const {
  if (form_ != Form::dome) return aerosol_of(amount_at(amount.place));
  return {amount_at(amount.place), amount.exponent, *kind_};
}

Turbidity SkyFamily::turbidity_at(const SkyAmount& amount) const {
  return {form_ == Form::dome ? turbidity_of(aerosol_at(amount)) : amount_at(amount.place)};
}

double SkyFamily::place_of(double aod_550) const {
  const double known = form_ == Form::dome ? aod_550 : turbidity_of({.aod_550 = aod_550});
  return std::clamp((std::log(known + shift_) - first_) / step_, 0.0, nodes_ - 1.0);
}

double SkyFamily::aod_slope(const SkyAmount& amount) const {
  const double by_place = step_ * (amount_at(amount.place) + shift_);
  return form_ == Form::dome ? by_place : by_place * (aerosol_of(3.0).aod_550 - aerosol_of(2.0).aod_550);
}

LightOfSky SkyFamily::light(const SkyAmount& amount) const {
  if (form_ == Form::dome)
    return [sky = dome_in_srgb(altitude_m_, aerosol_at(amount), sun_)](const Direction& view) {
      return dome_light(sky, view);
    };
  const Turbidity turbidity = turbidity_at(amount);
  if (form_ == Form::preetham)
    return [sky = SkyModel(turbidity, sun_), to_srgb = xyz_to_linear_srgb()](const Direction& view) {
      return to_srgb * sky.relative_xyz(view);
    };
  return [sky = hosek_->sky(turbidity, kHosekGround, sun_)](const Direction& view) { return sky.linear_srgb(view); };
}

std::array<Eigen::MatrixXd, 3> SkyFamily::log_light(std::span<const Direction> directions) const {
  const auto rows = static_cast<Eigen::Index>(directions.size());
  std::array<Eigen::MatrixXd, 3> table;
  for (auto& channel : table) channel.resize(rows, nodes_);
  if (form_ == Form::dome) {
    // The dome is linear in its coefficients: one product of matrices.
    Eigen::MatrixXd terms(rows, kDomeTerms), coefficients(kDomeTerms, 3 * nodes_);
    for (int k = 0; k < nodes_; ++k) {
      const DomeFunction sky = dome_in_srgb(altitude_m_, {amount_at(k), natural_exponent(), *kind_}, sun_);
      for (int t = 0; t < kDomeTerms; ++t)
        for (int c = 0; c < 3; ++c)
          coefficients(t, 3 * k + c) = static_cast<double>(sky.coefficients[static_cast<std::size_t>(t)][c]);
      if (k > 0) continue;
      for (Eigen::Index i = 0; i < rows; ++i) {
        const auto of_view = dome_terms(sky, directions[static_cast<std::size_t>(i)]);
        for (int t = 0; t < kDomeTerms; ++t) terms(i, t) = of_view[static_cast<std::size_t>(t)];
      }
    }
    const Eigen::MatrixXd light = terms * coefficients;
    for (int k = 0; k < nodes_; ++k)
      for (int c = 0; c < 3; ++c)
        table[static_cast<std::size_t>(c)].col(k) = light.col(3 * k + c).array().max(kDarkestLight).log();
    return table;
  }
  for (int k = 0; k < nodes_; ++k) {
    const LightOfSky at = light({static_cast<double>(k), 0.0});
    for (Eigen::Index i = 0; i < rows; ++i) {
      const glm::dvec3 rgb = at(directions[static_cast<std::size_t>(i)]);
      for (int c = 0; c < 3; ++c) table[static_cast<std::size_t>(c)](i, k) = std::log(std::max(rgb[c], kDarkestLight));
    }
  }
  return table;
}

std::array<Eigen::VectorXd, 3> SkyFamily::log_light(const std::array<Eigen::MatrixXd, 3>& table,
                                                    const SkyAmount& amount) const {
  const auto places = channel_places(amount);
  std::array<Eigen::VectorXd, 3> light;
  for (std::size_t c = 0; c < 3; ++c) {
    const CubicTaps taps = cubic_taps(places[c].place, nodes_);
    light[c] = table[c].middleCols<4>(taps.first) * Eigen::Map<const Eigen::Vector4d>(taps.value.data());
  }
  return light;
}

DoubtsOfLight SkyFamily::doubts(const std::array<Eigen::MatrixXd, 3>& table, const SkyAmount& amount,
                                std::span<const Direction> directions, double brighter_ground) const {
  if (form_ == Form::dome)
    return sky_doubts(aerosol_at(amount), altitude_m_, sun_, directions, log_light(table, amount), on_ground_,
                      brighter_ground);
  DoubtsOfLight none;
  none.fill(Eigen::MatrixXd(static_cast<Eigen::Index>(directions.size()), 0));
  return none;
}

std::array<SkyFamily::ChannelPlace, 3> SkyFamily::channel_places(const SkyAmount& amount) const {
  std::array<ChannelPlace, 3> places;
  places.fill({amount.place, 1.0, 0.0});
  if (form_ != Form::dome) return places;
  const double aod = amount_at(amount.place), tilt = natural_exponent() - amount.exponent;
  for (int c = 0; c < 3; ++c) {
    const double log_nm = std::log(kDomeChannels_nm[c] / 550.0), share = std::exp(tilt * log_nm), own = aod * share;
    auto& place = places[static_cast<std::size_t>(c)];
    place.place = (std::log(own + shift_) - first_) / step_;
    place.by_place = share * (aod + shift_) / (own + shift_);
    place.by_exponent = -own * log_nm / ((own + shift_) * step_);
  }
  return places;
}

}  // namespace kasumi
