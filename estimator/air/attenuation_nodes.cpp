// Where the nodes of a spectral measure lie: a fit of weight and two wavelengths to the 1 nm reference over a
// logarithmic grid of turbidities and paths. It halves the worst error of the Gauss nodes in 1 / wavelength.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <ceres/ceres.h>

#include "estimator/air/attenuation.hpp"

namespace kasumi {
namespace {

constexpr double kUnit_nm = 550.0;

// One grid point: optical depths at 550 nm, where Rayleigh goes with lambda^-4 and Mie with lambda^-2.
struct Depths {
  double rayleigh = 0.0;
  double mie = 0.0;
};

std::vector<Depths> grid() {
  constexpr int kTurbidities = 16;
  constexpr int kPaths = 32;
  constexpr double kShortest_m = 30.0;
  constexpr double kLongest_m = 50e3;
  std::vector<Depths> points;
  const double rayleigh = rayleigh_per_m(ScatteringModel::morales2017, kUnit_nm);
  for (int i = 0; i < kTurbidities; ++i) {
    const double above_pure = std::lerp(std::log(kLowestTurbidity.value - 1.0), std::log(kHighestTurbidity.value - 1.0),
                                        i / (kTurbidities - 1.0));
    const double mie = mie_per_m(ScatteringModel::morales2017, kUnit_nm, Turbidity{1.0 + std::exp(above_pure)});
    for (int j = 0; j < kPaths; ++j) {
      const double path_m = kShortest_m * std::pow(kLongest_m / kShortest_m, j / (kPaths - 1.0));
      points.push_back({rayleigh * path_m, mie * path_m});
    }
  }
  return points;
}

double transmittance(const Depths& depths, double wavelength) {
  const double inverse_square = 1.0 / (wavelength * wavelength);
  return std::exp(-(depths.rayleigh * inverse_square + depths.mie) * inverse_square);
}

// The measure's own attenuation at the grid's points, in all channels.
std::vector<glm::dvec3> exact(const SpectralMeasure& measure, const std::vector<Depths>& points) {
  std::vector<glm::dvec3> gamma(points.size(), glm::dvec3{0.0});
  for (std::size_t i = 0; i < measure.weight.size(); ++i) {
    const double wavelength = (measure.first_nm + static_cast<double>(i)) / kUnit_nm;
    for (std::size_t p = 0; p < points.size(); ++p) {
      gamma[p] += measure.weight[i] * transmittance(points[p], wavelength);
    }
  }
  return gamma;
}

// The first node's weight (the second has the rest), then both wavelengths in units of 550 nm.
using Pair = std::array<double, 3>;

double worst_error(const Pair& pair, const std::vector<Depths>& points, const std::vector<double>& gamma) {
  double worst = 0.0;
  for (std::size_t p = 0; p < points.size(); ++p) {
    const double found =
        pair[0] * transmittance(points[p], pair[1]) + (1.0 - pair[0]) * transmittance(points[p], pair[2]);
    worst = std::max(worst, std::abs(found - gamma[p]));
  }
  return worst;
}

// Residual (error / 1e-3)^power: power 1 is least squares; power 4 (a sum of eighth powers) approximates the minimax
// fit.
class PairError final : public ceres::CostFunction {
 public:
  PairError(const std::vector<Depths>& points, const std::vector<double>& gamma, int power)
      : points_(points), gamma_(gamma), power_(power) {
    set_num_residuals(static_cast<int>(points.size()));
    mutable_parameter_block_sizes()->push_back(3);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const double weight = parameters[0][0], first = parameters[0][1], second = parameters[0][2];
    for (std::size_t p = 0; p < points_.size(); ++p) {
      const double t1 = transmittance(points_[p], first), t2 = transmittance(points_[p], second);
      const double error = (weight * t1 + (1.0 - weight) * t2 - gamma_[p]) / kScale;
      residuals[p] = std::pow(error, power_);
      if (!jacobians || !jacobians[0]) continue;
      const double outer = power_ * std::pow(error, power_ - 1) / kScale;
      double* row = jacobians[0] + 3 * p;
      row[0] = outer * (t1 - t2);
      row[1] = outer * weight * t1 * depth_slope(points_[p], first);
      row[2] = outer * (1.0 - weight) * t2 * depth_slope(points_[p], second);
    }
    return true;
  }

 private:
  static constexpr double kScale = 1e-3;
  static double depth_slope(const Depths& depths, double wavelength) {  // -d depth / d wavelength
    return 4.0 * depths.rayleigh * std::pow(wavelength, -5) + 2.0 * depths.mie * std::pow(wavelength, -3);
  }

  const std::vector<Depths>& points_;
  const std::vector<double>& gamma_;
  int power_;
};

void refine(Pair& pair, const std::vector<Depths>& points, const std::vector<double>& gamma, int power) {
  ceres::Problem problem;
  problem.AddResidualBlock(new PairError(points, gamma, power), nullptr, pair.data());
  for (const int wavelength : {1, 2}) {
    problem.SetParameterLowerBound(pair.data(), wavelength, 0.4);
    problem.SetParameterUpperBound(pair.data(), wavelength, 2.5);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.num_threads = 1;
  options.max_num_iterations = 100;
  options.function_tolerance = 1e-9;
  options.parameter_tolerance = 1e-10;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
}

// Least squares over a coarse grid of both wavelengths; the weight for each pair is linear and has a closed form. A
// grid search is needed because a signed measure has several minima and may have no Gauss nodes at all.
Pair coarse_pair(const std::vector<Depths>& points, const std::vector<double>& gamma) {
  constexpr double kShortest = 0.5, kStep = 0.025;
  constexpr int kWavelengths = 41;
  std::vector<std::vector<double>> through(kWavelengths, std::vector<double>(points.size()));
  for (std::size_t i = 0; i < through.size(); ++i) {
    const double wavelength = kShortest + kStep * static_cast<double>(i);
    for (std::size_t p = 0; p < points.size(); ++p) through[i][p] = transmittance(points[p], wavelength);
  }
  Pair best{0.5, 1.0, 1.0};
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < through.size(); ++i) {
    for (std::size_t j = i + 1; j < through.size(); ++j) {
      double dd = 0.0, dr = 0.0, rr = 0.0;
      for (std::size_t p = 0; p < points.size(); ++p) {
        const double difference = through[i][p] - through[j][p];
        const double rest = gamma[p] - through[j][p];
        dd += difference * difference;
        dr += difference * rest;
        rr += rest * rest;
      }
      const double squares = rr - dr * dr / dd;
      if (squares < least) {
        least = squares;
        best = {dr / dd, kShortest + kStep * static_cast<double>(i), kShortest + kStep * static_cast<double>(j)};
      }
    }
  }
  return best;
}

Pair best_pair(const std::vector<Depths>& points, const std::vector<double>& gamma) {
  Pair best = coarse_pair(points, gamma);
  double least = worst_error(best, points, gamma);
  Pair pair = best;
  for (const int power : {1, 4}) {
    refine(pair, points, gamma, power);
    if (const double worst = worst_error(pair, points, gamma); worst < least) {
      least = worst;
      best = pair;
    }
  }
  return best;
}

}  // namespace

AttenuationNodes attenuation_nodes(const SpectralMeasure& measure) {
  const std::vector<Depths> points = grid();
  const std::vector<glm::dvec3> gamma = exact(measure, points);
  AttenuationNodes nodes;
  for (int c = 0; c < 3; ++c) {
    std::vector<double> channel(points.size());
    for (std::size_t p = 0; p < points.size(); ++p) channel[p] = gamma[p][c];
    const Pair pair = best_pair(points, channel);
    nodes.weight[0][c] = pair[0];
    nodes.weight[1][c] = 1.0 - pair[0];
    nodes.wavelength_nm[0][c] = pair[1] * kUnit_nm;
    nodes.wavelength_nm[1][c] = pair[2] * kUnit_nm;
  }
  return nodes;
}

}  // namespace kasumi
