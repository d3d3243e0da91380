#include "tests/estimator/turbidity/ceres_reference.hpp"

#include <cmath>

#include <ceres/ceres.h>

namespace kasumi::test {

namespace {

struct Residual {
  double zenith, gamma, log_y, weight;
  template <class T>
  bool operator()(const T* turbidity, const T* log_gain, T* residual) const {
    using std::exp, std::log;
    const T& t = *turbidity;
    const T a = .1787 * t - 1.4630, b = -.3554 * t + .4275, c = -.0227 * t + 5.3251, d = .1206 * t - 2.5771,
            e = -.0670 * t + .3703;
    const T f =
        (1.0 + a * exp(b / std::cos(zenith))) * (1.0 + c * exp(d * gamma) + e * (std::cos(gamma) * std::cos(gamma)));
    *residual = std::sqrt(weight) * (log_y - *log_gain - log(f));
    return true;
  }
};

}  // namespace

CeresSolution solve_by_ceres(std::span<const LuminanceSample> samples, std::span<const double> weights, double start) {
  CeresSolution solution{start, 0.0, 0.0};
  ceres::Problem problem;
  for (std::size_t i = 0; i < samples.size(); ++i)
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Residual, 1, 1, 1>(new Residual{
                                 static_cast<double>(samples[i].zenith), static_cast<double>(samples[i].sun_distance),
                                 static_cast<double>(samples[i].log_luminance), weights[i]}),
                             nullptr, &solution.turbidity, &solution.log_gain);
  problem.SetParameterLowerBound(&solution.turbidity, 0, 1.7);
  problem.SetParameterUpperBound(&solution.turbidity, 0, 20.0);
  ceres::Solver::Options options;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  solution.cost = 2.0 * summary.final_cost;  // Ceres halves the squares
  return solution;
}

}  // namespace kasumi::test
