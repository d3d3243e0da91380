// Where the nodes of a spectral measure lie: a fit of weight and two wavelengths to the 1 nm reference over a
// logarithmic grid of turbidities and paths. It halves the worst error of the Gauss nodes in 1 / wavelength. The laws by
// which extinction goes with wavelength are the papers' and the air's own.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <ceres/ceres.h>

#include "estimator/air/attenuation.hpp"

namespace kasumi {
namespace {

constexpr double kUnit_nm = 550.0;  // the wavelength at which every optical depth here is stated

// One grid point: optical depths at 550 nm.
struct Depths {
  double rayleigh = 0.0;
  double mie = 0.0;
};

// The papers: Rayleigh goes with lambda^-4 and Mie with lambda^-2. Wavelengths in units of 550 nm.
struct PapersLaw {
  using Ratios = double;                                       // lambda^-2
  static constexpr double kClearest = kLowestTurbidity.value;  // the clearest air of the papers
  static double rayleigh_per_m() { return kasumi::rayleigh_per_m(ScatteringModel::morales2017, kUnit_nm); }
  static double mie_per_m(double turbidity) {
    return kasumi::mie_per_m(ScatteringModel::morales2017, kUnit_nm, Turbidity{turbidity});
  }
  static Ratios at(double wavelength) { return 1.0 / (wavelength * wavelength); }
  static double transmittance(const Depths& depths, Ratios inverse_square) {
    return std::exp(-(depths.rayleigh * inverse_square + depths.mie) * inverse_square);
  }
  static double depth_slope(const Depths& depths, double wavelength) {  // -d depth / d wavelength
    return 4.0 * depths.rayleigh * std::pow(wavelength, -5) + 2.0 * depths.mie * std::pow(wavelength, -3);
  }
};

// The air as it is: molecules after Bodhaine, aerosol by Angstrom's law.
struct AerosolLaw {
  double exponent;
  struct Ratios {
    double molecules = 1.0, aerosol = 1.0;
  };
  static constexpr double kClearest = 1.5;  // T of an optical depth of about .05
  static double rayleigh_per_m() { return kasumi::rayleigh_per_m(ScatteringModel::aerosol, kUnit_nm); }
  double mie_per_m(double turbidity) const {
    return kasumi::mie_per_m(ScatteringModel::aerosol, kUnit_nm, aerosol_of(turbidity, exponent));
  }
  Ratios at(double wavelength) const {
    return {molecular_optical_depth(kUnit_nm * wavelength) / molecular_optical_depth(kUnit_nm),
            std::pow(wavelength, -exponent)};
  }
  static double transmittance(const Depths& depths, const Ratios& ratios) {
    return std::exp(-(depths.rayleigh * ratios.molecules + depths.mie * ratios.aerosol));
  }
  double depth_slope(const Depths& depths, double wavelength) const {
    constexpr double kStep = 1e-5;  // of a numerical derivative by wavelength, in units of 550 nm
    const Ratios below = at(wavelength - kStep), above = at(wavelength + kStep);
    return (depths.rayleigh * (below.molecules - above.molecules) + depths.mie * (below.aerosol - above.aerosol)) /
           (2.0 * kStep);
  }
};

template <class Law>
std::vector<Depths> grid(const Law& law) {
  // Even ratios of T - 1 and of path length, 27 % from path to path: the sums change slowly over both. From nearly no
  // air to the farthest hill that haze leaves visible.
  constexpr int kTurbidities = 16;
  constexpr int kPaths = 32;
  constexpr double kShortest_m = 30.0;
  constexpr double kLongest_m = 50e3;
  std::vector<Depths> points;
  const double rayleigh = law.rayleigh_per_m();
  for (int i = 0; i < kTurbidities; ++i) {
    const double above_pure =
        std::lerp(std::log(Law::kClearest - 1.0), std::log(kHighestTurbidity.value - 1.0), i / (kTurbidities - 1.0));
    const double mie = law.mie_per_m(1.0 + std::exp(above_pure));
    for (int j = 0; j < kPaths; ++j) {
      const double path_m = kShortest_m * std::pow(kLongest_m / kShortest_m, j / (kPaths - 1.0));
      points.push_back({rayleigh * path_m, mie * path_m});
    }
  }
  return points;
}

// The measure's own attenuation at the grid's points, in all channels.
template <class Law>
std::vector<glm::dvec3> exact(const SpectralMeasure& measure, const std::vector<Depths>& points, const Law& law) {
  std::vector<glm::dvec3> gamma(points.size(), glm::dvec3{0.0});
  for (std::size_t i = 0; i < measure.weight.size(); ++i) {
    const auto ratios = law.at((measure.first_nm + static_cast<double>(i)) / kUnit_nm);
    for (std::size_t p = 0; p < points.size(); ++p)
      gamma[p] += measure.weight[i] * law.transmittance(points[p], ratios);
  }
  return gamma;
}

// The first node's weight (the second has the rest), then both wavelengths in units of 550 nm.
using Pair = std::array<double, 3>;

// What a pair is fitted to: one channel.
template <class Law>
struct Channel {
  const Law& law;
  const std::vector<Depths>& points;
  const std::vector<double>& gamma;

  double worst_error(const Pair& pair) const {
    const auto first = law.at(pair[1]), second = law.at(pair[2]);
    double worst = 0.0;
    for (std::size_t p = 0; p < points.size(); ++p) {
      const double found =
          pair[0] * law.transmittance(points[p], first) + (1.0 - pair[0]) * law.transmittance(points[p], second);
      worst = std::max(worst, std::abs(found - gamma[p]));
    }
    return worst;
  }
};

// Residual (error / 1e-3)^power: power 1 is least squares; power 4 (a sum of eighth powers) approximates the minimax
// fit.
template <class Law>
class PairError final : public ceres::CostFunction {
 public:
  PairError(const Channel<Law>& channel, int power) : channel_(channel), power_(power) {
    set_num_residuals(static_cast<int>(channel.points.size()));
    mutable_parameter_block_sizes()->push_back(3);
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const auto& [law, points, gamma] = channel_;
    const double weight = parameters[0][0], first = parameters[0][1], second = parameters[0][2];
    const auto at_first = law.at(first), at_second = law.at(second);
    for (std::size_t p = 0; p < points.size(); ++p) {
      const double t1 = law.transmittance(points[p], at_first), t2 = law.transmittance(points[p], at_second);
      const double error = (weight * t1 + (1.0 - weight) * t2 - gamma[p]) / kScale;
      residuals[p] = std::pow(error, power_);
      if (!jacobians || !jacobians[0]) continue;
      const double outer = power_ * std::pow(error, power_ - 1) / kScale;
      double* row = jacobians[0] + 3 * p;
      row[0] = outer * (t1 - t2);
      row[1] = outer * weight * t1 * law.depth_slope(points[p], first);
      row[2] = outer * (1.0 - weight) * t2 * law.depth_slope(points[p], second);
    }
    return true;
  }

 private:
  // Brings the residuals to the order of 1, at which Ceres' tolerances are meant.
  static constexpr double kScale = 1e-3;
  const Channel<Law>& channel_;
  int power_;
};

template <class Law>
void refine(Pair& pair, const Channel<Law>& channel, int power) {
  ceres::Problem problem;
  problem.AddResidualBlock(new PairError<Law>(channel, power), nullptr, pair.data());
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
template <class Law>
Pair coarse_pair(const Channel<Law>& channel) {
  // 275 to 825 nm in steps of 13.75 nm, wider than what a camera sees: Gauss nodes of a signed measure may lie outside.
  constexpr double kShortest = 0.5, kStep = 0.025;
  constexpr int kWavelengths = 41;
  const auto& [law, points, gamma] = channel;
  std::vector<std::vector<double>> through(kWavelengths, std::vector<double>(points.size()));
  for (std::size_t i = 0; i < through.size(); ++i) {
    const auto ratios = law.at(kShortest + kStep * static_cast<double>(i));
    for (std::size_t p = 0; p < points.size(); ++p) through[i][p] = law.transmittance(points[p], ratios);
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

template <class Law>
Pair best_pair(const Channel<Law>& channel) {
  Pair best = coarse_pair(channel);
  double least = channel.worst_error(best);
  Pair pair = best;
  for (const int power : {1, 4}) {
    refine(pair, channel, power);
    if (const double worst = channel.worst_error(pair); worst < least) {
      least = worst;
      best = pair;
    }
  }
  return best;
}

template <class Law>
AttenuationNodes nodes_under(const Law& law, const SpectralMeasure& measure) {
  const std::vector<Depths> points = grid(law);
  const std::vector<glm::dvec3> gamma = exact(measure, points, law);
  AttenuationNodes nodes;
  for (int c = 0; c < 3; ++c) {
    std::vector<double> channel(points.size());
    for (std::size_t p = 0; p < points.size(); ++p) channel[p] = gamma[p][c];
    const Pair pair = best_pair(Channel<Law>{law, points, channel});
    nodes.weight[0][c] = pair[0];
    nodes.weight[1][c] = 1.0 - pair[0];
    nodes.wavelength_nm[0][c] = pair[1] * kUnit_nm;
    nodes.wavelength_nm[1][c] = pair[2] * kUnit_nm;
  }
  return nodes;
}

}  // namespace

AttenuationNodes attenuation_nodes(const SpectralMeasure& measure) {
  return nodes_under(PapersLaw{}, measure);
}

AttenuationNodes attenuation_nodes(const SpectralMeasure& measure, double angstrom_exponent) {
  return nodes_under(AerosolLaw{angstrom_exponent}, measure);
}

AttenuationNodes attenuation_nodes(const SpectralMeasure& measure, ScatteringModel model, const AirState& air) {
  return model == ScatteringModel::aerosol ? attenuation_nodes(measure, air.aerosol().angstrom_exponent)
                                           : attenuation_nodes(measure);
}

}  // namespace kasumi
