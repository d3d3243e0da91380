// What readings of a sky could tell of its aerosol at best (Cramer and Rao): by which gains are free, and by what is
// believed of the models' own errors. Printed before a way of fitting was chosen.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/dome.hpp"
#include "tests/estimator/sky_fit/skies_as_readings.hpp"
#include "tests/figures.hpp"

namespace kasumi::test {
namespace {

enum class Gain { one, per_channel };
struct Freedom {
  const char* name;
  Gain gain;
  bool vignetting, discrepancy;
};
constexpr std::array<Freedom, 8> kFreedoms{{{"one gain", Gain::one, false, false},
                                            {"one, vignetting", Gain::one, true, false},
                                            {"a gain per channel", Gain::per_channel, false, false},
                                            {"per channel, vignetting", Gain::per_channel, true, false},
                                            {"one gain", Gain::one, false, true},
                                            {"one, vignetting", Gain::one, true, true},
                                            {"a gain per channel", Gain::per_channel, false, true},
                                            {"per channel, vignetting", Gain::per_channel, true, true}}};

// A sky's ln light, channel by channel, and how sure each number is: white noise of 1 %, and errors that keep over .6 rad
// and between channels: 3 % of light, 1.5 % of each channel's own.
class BoundedSky {
 public:
  BoundedSky(const SunDirection& sun, bool discrepancy) : sun_(sun), directions_(spread_directions(sun, 150)) {
    const auto n = static_cast<Eigen::Index>(directions_.size());
    Eigen::MatrixXd covariance = 1e-4 * Eigen::MatrixXd::Identity(3 * n, 3 * n);
    if (discrepancy)
      for (Eigen::Index i = 0; i < n; ++i)
        for (Eigen::Index j = 0; j < n; ++j) {
          const double apart =
              std::sqrt(3.0) *
              angle_between(directions_[static_cast<std::size_t>(i)], directions_[static_cast<std::size_t>(j)]).value /
              0.6;
          const double alike = (1.0 + apart) * std::exp(-apart);
          for (Eigen::Index c = 0; c < 3; ++c)
            for (Eigen::Index d = 0; d < 3; ++d)
              covariance(c * n + i, d * n + j) += (9e-4 + (c == d ? 2.25e-4 : 0.0)) * alike;
        }
    factor_.compute(covariance);
  }
  Eigen::VectorXd log_light(const Aerosol& aerosol) const {
    const DomeFunction sky = in_space(dome(0.0, aerosol, sun_), xyz_to_linear_srgb());
    const auto n = static_cast<Eigen::Index>(directions_.size());
    Eigen::VectorXd light(3 * n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const glm::dvec3 rgb = dome_light(sky, directions_[static_cast<std::size_t>(i)]);
      for (Eigen::Index c = 0; c < 3; ++c) light[c * n + i] = std::log(std::max(rgb[static_cast<int>(c)], 1e-6));
    }
    return light;
  }
  // ln AOD and the exponent, then what an instrument leaves open; whitened.
  Eigen::MatrixXd slopes(const Aerosol& at, const Freedom& freedom) const {
    const auto n = static_cast<Eigen::Index>(directions_.size());
    Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(3 * n, 6);
    const auto with = [&](double log_aod, double exponent) {
      return log_light({at.aod_550 * std::exp(log_aod), at.angstrom_exponent + exponent, at.kind});
    };
    constexpr double kStep = 0.02;
    columns.col(0) = (with(kStep, 0.0) - with(-kStep, 0.0)) / (2.0 * kStep);
    // Both beside the kind's own exponent, at which no channel is taken on its own.
    columns.col(1) = (with(0.0, 0.1) - with(0.0, 0.05)) / 0.05;
    Eigen::Index used = 2;
    if (freedom.gain == Gain::one) {
      columns.col(used++).setOnes();
    } else {
      for (Eigen::Index c = 0; c < 3; ++c) columns.col(used++).segment(c * n, n).setOnes();
    }
    if (freedom.vignetting) {
      for (Eigen::Index i = 0; i < 3 * n; ++i)
        columns(i, used) = std::pow(zenith_angle(directions_[static_cast<std::size_t>(i % n)]).value / (0.5 * kPi), 2);
      ++used;
    }
    return white(columns.leftCols(used));
  }
  Eigen::MatrixXd white(Eigen::MatrixXd columns) const {
    factor_.matrixL().solveInPlace(columns);
    return columns;
  }

 private:
  SunDirection sun_;
  std::vector<Direction> directions_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

// Standard deviations of ln AOD and of the exponent.
Eigen::Vector2d bound_of(const BoundedSky& sky, const Aerosol& aerosol, const Freedom& freedom) {
  const Eigen::MatrixXd slopes = sky.slopes(aerosol, freedom);
  const Eigen::MatrixXd inverse =
      (slopes.transpose() * slopes + 1e-9 * Eigen::MatrixXd::Identity(slopes.cols(), slopes.cols())).inverse();
  return inverse.diagonal().head<2>().cwiseSqrt();
}

// By how many standard deviations the other kind's nearest sky differs.
double distance_to(const BoundedSky& sky, const Aerosol& truth, AerosolKind other, const Freedom& freedom) {
  Aerosol nearest{truth.aod_550, truth.angstrom_exponent, other};
  const Eigen::VectorXd light = sky.log_light(truth);
  double distance = 0.0;
  for (int turn = 0; turn < 6; ++turn) {
    const Eigen::MatrixXd slopes = sky.slopes(nearest, freedom);
    const Eigen::VectorXd off = sky.white(light - sky.log_light(nearest));
    const Eigen::VectorXd step = slopes.colPivHouseholderQr().solve(off);
    distance = (off - slopes * step).norm();
    nearest.aod_550 = std::clamp(nearest.aod_550 * std::exp(std::clamp(step[0], -0.5, 0.5)), 0.002, 1.7);
    nearest.angstrom_exponent = std::clamp(nearest.angstrom_exponent + std::clamp(step[1], -0.5, 0.5), -0.5, 2.5);
  }
  return distance;
}

TEST(SkyFitBounds, OfAmountAndExponent) {
  const auto kinds = figure_cases<AerosolKind>("kinds", {AerosolKind::continental, AerosolKind::dust},
                                               {kAerosolKinds.begin(), kAerosolKinds.end()});
  fmt::print(
      "Least sigma of ln AOD and of the exponent; some 135 directions. First four: noise of 1 %; last four: also "
      "smooth errors of 3 %\n"
      "| kind, AOD, sun from the zenith |");
  for (const Freedom& freedom : kFreedoms) fmt::print(" {} |", freedom.name);
  fmt::print("\n");
  for (const AerosolKind kind : kinds)
    for (const double zenith_deg : {35.0, 65.0}) {
      const SunDirection sun = direction_from(from_degrees(zenith_deg), from_degrees(40.0));
      const BoundedSky noise(sun, false), smooth(sun, true);
      for (const double aod : {0.03, 0.1, 0.4}) {
        fmt::print("| {}, {}, {} deg |", name_of(kind), aod, zenith_deg);
        std::array<Eigen::Vector2d, kFreedoms.size()> bounds;
        for (std::size_t k = 0; k < kFreedoms.size(); ++k) {
          bounds[k] =
              bound_of(kFreedoms[k].discrepancy ? smooth : noise, {aod, natural_exponent(kind), kind}, kFreedoms[k]);
          fmt::print(" {:.3f}, {:.2f} |", bounds[k][0], bounds[k][1]);
        }
        fmt::print("\n");
        for (std::size_t k = 0; k < 4; ++k) {
          EXPECT_LT(bounds[k][0], bounds[k + 4][0]);  // errors cost
          EXPECT_LT(bounds[k][0], 0.1);
        }
        EXPECT_LE(bounds[0][0], bounds[3][0]);  // and so does freedom
      }
    }
}

TEST(SkyFitBounds, OfTheKinds) {
  fmt::print(
      "\nFrom each kind to the one that is hardest to tell from it, in standard deviations; a gain per channel\n"
      "| kind, AOD .1, sun 50 deg from the zenith | noise of 1 % | and smooth errors of 3 % |\n");
  const SunDirection sun = direction_from(from_degrees(50.0), from_degrees(40.0));
  const BoundedSky noise(sun, false), smooth(sun, true);
  for (const AerosolKind kind : kAerosolKinds) {
    const Aerosol truth{0.1, natural_exponent(kind), kind};
    std::array<double, 2> least{1e9, 1e9};
    std::array<AerosolKind, 2> nearest{};
    for (const AerosolKind other : kAerosolKinds)
      for (std::size_t k = 0; other != kind && k < 2; ++k) {
        const double distance = distance_to(k == 0 ? noise : smooth, truth, other, kFreedoms[k == 0 ? 2 : 6]);
        if (distance >= least[k]) continue;
        least[k] = distance;
        nearest[k] = other;
      }
    fmt::print("| {} | {}, {:.1f} | {}, {:.1f} |\n", name_of(kind), name_of(nearest[0]), least[0], name_of(nearest[1]),
               least[1]);
    EXPECT_LT(least[1], least[0]);
  }
  fmt::print("Where this is below some 3 a sky does not tell the two apart, whatever the fit.\n");
}

// Fine particles (smoke's and, larger, continental air's) beside desert's coarse ones.
struct PartsOfAir {
  double log_aod = std::log(0.2), exponent = 1.3;
  double coarse = 0.3;     // of the depth at 550 nm
  double larger = 0.3;     // of the fine ones' depth, of continental air's
  double absorbing = 0.2;  // of the fine ones' depth, of town air's: each tenth takes .011 off their albedo
};

Eigen::VectorXd light_of_parts(const BoundedSky& sky, const PartsOfAir& air) {
  using enum AerosolKind;
  const double fine = 1.0 - air.coarse;
  const std::array<std::pair<AerosolKind, double>, 4> parts{{{smoke, fine * (1.0 - air.larger - air.absorbing)},
                                                             {continental, fine * air.larger},
                                                             {urban, fine * air.absorbing},
                                                             {desert, air.coarse}}};
  Eigen::VectorXd light;
  Eigen::Vector3d whole = Eigen::Vector3d::Zero();
  for (const auto& [kind, share] : parts) {
    const Eigen::VectorXd of_kind = sky.log_light({std::exp(air.log_aod), air.exponent, kind});
    const auto n = of_kind.size() / 3;
    if (light.size() == 0) light = Eigen::VectorXd::Zero(of_kind.size());
    for (Eigen::Index c = 0; c < 3; ++c) {
      const double in_channel =
          share * std::pow(kDomeChannels_nm[static_cast<int>(c)] / 550.0, -natural_exponent(kind));
      whole[c] += in_channel;
      light.segment(c * n, n).array() += in_channel * of_kind.segment(c * n, n).array().exp();
    }
  }
  const auto n = light.size() / 3;
  for (Eigen::Index c = 0; c < 3; ++c) light.segment(c * n, n) /= whole[c];
  return light.array().log();
}

TEST(SkyFitBounds, OfParticlesSetFree) {
  fmt::print(
      "\nLeast sigma where particles are free, a gain per channel; noise of 1 %, and with smooth errors of 3 %\n"
      "| AOD, sun from the zenith | ln AOD | exponent | coarse share | share of larger fine ones | albedo |\n");
  constexpr std::array<double PartsOfAir::*, 5> kParts{&PartsOfAir::log_aod, &PartsOfAir::exponent, &PartsOfAir::coarse,
                                                       &PartsOfAir::larger, &PartsOfAir::absorbing};
  constexpr std::array kUnits{1.0, 1.0, 1.0, 1.0, 0.11};
  for (const double zenith_deg : {35.0, 65.0}) {
    const SunDirection sun = direction_from(from_degrees(zenith_deg), from_degrees(40.0));
    const BoundedSky noise(sun, false), smooth(sun, true);
    for (const double aod : {0.05, 0.2, 0.6}) {
      std::array<std::array<double, kParts.size()>, 2> bounds{};
      for (std::size_t k = 0; k < 2; ++k) {
        const BoundedSky& sky = k == 0 ? noise : smooth;
        const Eigen::VectorXd here = light_of_parts(sky, {std::log(aod)});
        Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(here.size(), kParts.size() + 3);
        constexpr double kStep = 0.02;
        for (std::size_t u = 0; u < kParts.size(); ++u) {
          PartsOfAir less{std::log(aod)}, more = less;
          less.*kParts[u] -= kStep;
          more.*kParts[u] += kStep;
          slopes.col(static_cast<Eigen::Index>(u)) =
              (light_of_parts(sky, more) - light_of_parts(sky, less)) / (2.0 * kStep);
        }
        for (Eigen::Index c = 0; c < 3; ++c)
          slopes.col(static_cast<Eigen::Index>(kParts.size()) + c)
              .segment(c * here.size() / 3, here.size() / 3)
              .setOnes();
        const Eigen::MatrixXd white = sky.white(slopes);
        const Eigen::MatrixXd inverse = (white.transpose() * white).inverse();
        for (std::size_t u = 0; u < kParts.size(); ++u)
          bounds[k][u] = kUnits[u] * std::sqrt(inverse(static_cast<Eigen::Index>(u), static_cast<Eigen::Index>(u)));
      }
      std::vector<std::string> cells{fmt::format("{}, {:.0f} deg", figure_text(aod, 2), zenith_deg)};
      for (std::size_t u = 0; u < kParts.size(); ++u)
        cells.push_back(figure_text(bounds[0][u], 3) + "; " + figure_text(bounds[1][u], 2));
      for (const std::string& cell : cells) fmt::print("| {} ", cell);
      fmt::print("|\n");
      figure_row("particles-bounds", cells);
      EXPECT_LT(bounds[0][0], bounds[1][0]);
      EXPECT_LT(bounds[1][0], 0.6);
    }
  }
}

}  // namespace
}  // namespace kasumi::test
