#include "estimator/sky_fit/sky_family.hpp"

#include <algorithm>
#include <cmath>

#include <glm/exponential.hpp>

#include "base/sky/dome_terms.hpp"
#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/hosek.hpp"

namespace kasumi {
namespace {

constexpr double kDarkestLight = 1e-7;                // of any unit here; no daytime sky is as dark
constexpr int kDomeNodes = 19, kTurbidityNodes = 25;  // dome: .2 in ln(aod + .05)
// The dome is tabulated over ln(aod + .05): with as much aerosol its light equals the molecules', roughly.
constexpr double kDomeShift = 0.05;
constexpr double kHosekGround = 0.2;  // the reference atmosphere's

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

SkyFamily SkyFamily::blend(const SkyFamily& one, const SkyFamily& other) {
  SkyFamily family = one;
  family.other_ = other.kind_;
  family.on_ground_ = 0.5 * (one.on_ground_ + other.on_ground_);
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
  if (form_ == Form::hosek) return "hosek";
  std::string name = "dome, " + std::string(name_of(*kind_));
  if (other_) name += " and " + std::string(name_of(*other_));
  return name;
}

double SkyFamily::amount_at(double place) const {
  return std::max(0.0, std::exp(first_ + step_ * place) - shift_);
}

double SkyFamily::natural_exponent(double share) const {
  if (!kind_) return 1.3;
  return other_ ? kasumi::natural_exponent(*kind_, *other_, share) : kasumi::natural_exponent(*kind_);
}

Aerosol SkyFamily::aerosol_at(const FamilyPoint& amount, double natural_exponent) const {
  if (form_ != Form::dome) return aerosol_of(amount_at(amount.place));
  const double exponent = natural_exponent + amount.tilt;
  if (!other_) return {amount_at(amount.place), exponent, *kind_};
  return {amount_at(amount.place), exponent, *kind_, *other_, amount.share};
}

Turbidity SkyFamily::turbidity_of(const FamilyPoint& amount, const Aerosol& aerosol) const {
  return {form_ == Form::dome ? kasumi::turbidity_of(aerosol) : amount_at(amount.place)};
}

double SkyFamily::place_of(double aod_550) const {
  const double known = form_ == Form::dome ? aod_550 : kasumi::turbidity_of({.aod_550 = aod_550});
  return std::clamp((std::log(known + shift_) - first_) / step_, 0.0, nodes_ - 1.0);
}

RadianceField SkyFamily::light(const FamilyPoint& amount) const {
  if (form_ == Form::dome)
    return [sky = dome_in_srgb(altitude_m_, aerosol_at(amount), sun_)](const Direction& view) {
      return dome_light(sky, view);
    };
  const Turbidity turbidity{amount_at(amount.place)};
  if (form_ == Form::preetham)
    return [sky = PreethamSky(turbidity, sun_), to_srgb = xyz_to_linear_srgb()](const Direction& view) {
      return to_srgb * sky.relative_xyz(view);
    };
  return [sky = hosek_->sky(turbidity, kHosekGround, sun_)](const Direction& view) { return sky.linear_srgb(view); };
}

LightTable SkyFamily::log_light(std::span<const Direction> directions) const {
  const auto rows = static_cast<Eigen::Index>(directions.size());
  LightTable table;
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
    const RadianceField at = light({static_cast<double>(k), 0.0});
    for (Eigen::Index i = 0; i < rows; ++i) {
      const glm::dvec3 rgb = at(directions[static_cast<std::size_t>(i)]);
      for (int c = 0; c < 3; ++c) table[static_cast<std::size_t>(c)](i, k) = std::log(std::max(rgb[c], kDarkestLight));
    }
  }
  return table;
}

std::array<SkyFamily::Tap, 2> SkyFamily::taps(std::size_t channel, const FamilyPoint& amount) const {
  Tap one, other;
  one.place = amount.place;
  if (form_ != Form::dome) return {one, other};
  const double log_nm = std::log(kDomeChannels_nm[static_cast<int>(channel)] / 550.0), aod = amount_at(amount.place);
  // Extinction over that at 550 nm: of each kind and of both.
  const double share = other_ ? amount.share : 0.0, of_one = std::exp(-kasumi::natural_exponent(*kind_) * log_nm),
               of_other = other_ ? std::exp(-kasumi::natural_exponent(*other_) * log_nm) : of_one,
               both = (1.0 - share) * of_one + share * of_other, by_share = (of_other - of_one) / both;
  const auto lay = [&](Tap& tap, double of_kind) {
    const double scale = both / of_kind * std::exp(-amount.tilt * log_nm), own = aod * scale,
                 by_log = own / ((own + shift_) * step_);
    tap.place = (std::log(own + shift_) - first_) / step_;
    tap.place_by = {scale * (aod + shift_) / (own + shift_), -log_nm * by_log, by_share * by_log};
  };
  lay(one, of_one);
  lay(other, of_other);
  other.weight = share * of_other / both;
  one.weight = 1.0 - other.weight;
  other.weight_by_share = of_other / both - other.weight * by_share;
  one.weight_by_share = -other.weight_by_share;
  return {one, other};
}

std::array<Eigen::VectorXd, 3> SkyFamily::log_light(const FamilyTables& tables, const FamilyPoint& amount) const {
  std::array<Eigen::VectorXd, 3> light;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto [one, other] = taps(c, amount);
    const auto at = [&](const LightTable& table, const Tap& tap) {
      const CubicTaps cubic = cubic_taps(tap.place, nodes_);
      return (table[c].middleCols<4>(cubic.first) * Eigen::Map<const Eigen::Vector4d>(cubic.value.data())).eval();
    };
    light[c] = at(*tables.one, one);
    if (other_)
      light[c] = (one.weight * light[c].array().exp() + other.weight * at(*tables.other, other).array().exp()).log();
  }
  return light;
}

std::array<Eigen::MatrixXd, 3> SkyFamily::slopes(const FamilyTables& tables, const FamilyPoint& amount) const {
  std::array<Eigen::MatrixXd, 3> slopes;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto both = taps(c, amount);
    const auto rows = (*tables.one)[c].rows();
    slopes[c] = Eigen::MatrixXd::Zero(rows, kSkyUnknowns);
    Eigen::ArrayXd whole = Eigen::ArrayXd::Zero(rows);
    for (std::size_t k = 0; k < (other_ ? 2u : 1u); ++k) {
      const Tap& tap = both[k];
      const LightTable& table = k == 0 ? *tables.one : *tables.other;
      const CubicTaps cubic = cubic_taps(tap.place, nodes_);
      const auto four = table[c].middleCols<4>(cubic.first);
      const Eigen::VectorXd slope = four * Eigen::Map<const Eigen::Vector4d>(cubic.slope.data());
      Eigen::ArrayXd light = Eigen::ArrayXd::Ones(rows);
      if (other_) light = (four * Eigen::Map<const Eigen::Vector4d>(cubic.value.data())).array().exp();
      for (int u = 0; u < kSkyUnknowns; ++u)
        slopes[c].col(u).array() += tap.weight * light * slope.array() * tap.place_by[static_cast<std::size_t>(u)];
      slopes[c].col(kShare).array() += tap.weight_by_share * light;
      whole += tap.weight * light;
    }
    if (other_)
      slopes[c].array().colwise() /= whole;
    else
      slopes[c].col(kShare).setZero();
  }
  return slopes;
}

RadianceDoubts SkyFamily::doubts(const FamilyTables& tables, const FamilyPoint& amount,
                                 std::span<const Direction> directions, double brighter_ground) const {
  if (form_ == Form::dome)
    return sky_doubts(aerosol_at(amount), altitude_m_, sun_, directions, log_light(tables, amount), on_ground_,
                      brighter_ground);
  RadianceDoubts none;
  none.fill(Eigen::MatrixXd(static_cast<Eigen::Index>(directions.size()), 0));
  return none;
}

}  // namespace kasumi
