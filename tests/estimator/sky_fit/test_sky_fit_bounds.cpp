// What readings of a sky could tell of its aerosol at best (Cramer and Rao): by which gains are free, and by what is
// believed of the models' own errors. Printed before a way of fitting was chosen.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
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

}  // namespace
}  // namespace kasumi::test
