#include "calib/pose/pose_screening.hpp"

#include <algorithm>
#include <optional>

#include <Eigen/Dense>

namespace kasumi {
namespace {

// Of a squared studentised residual, by its degrees of freedom: exceeded once in a thousand.
constexpr double kContradicted1 = 10.8, kContradicted2 = 13.8;

Eigen::MatrixXd explained(const PoseFit& solved, std::size_t i) {
  return solved.slopes[i] * solved.covariance * solved.slopes[i].transpose();
}

}  // namespace

PoseMisfit misfit_of(const PoseFit& solved, const std::vector<bool>& used) {
  PoseMisfit misfit;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    misfit.chi2 += solved.residuals[i].squaredNorm();
    misfit.expected += static_cast<double>(solved.residuals[i].size()) - explained(solved, i).trace();
  }
  return misfit;
}

Contradiction contradiction(const PoseFit& solved, std::size_t i, bool used) {
  const auto rows = solved.residuals[i].size();
  if (rows == 0) return {1e18, 1.0};
  const Eigen::MatrixXd own = Eigen::MatrixXd::Identity(rows, rows);
  const Eigen::MatrixXd variance = own + (used ? -1.0 : 1.0) * explained(solved, i);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> axes(variance);
  Contradiction found{0.0, axes.eigenvalues().minCoeff()};
  for (int k = 0; k < rows; ++k) {
    const double along = axes.eigenvectors().col(k).dot(solved.residuals[i]);
    if (axes.eigenvalues()(k) > 0.01) found.squared += along * along / axes.eigenvalues()(k);
  }
  return found;
}

PoseFit fit_without_wrong(const PoseParameters& from, const ScaledLens& lens, const ScenePrior& prior,
                          const PoseSights& sights, std::vector<bool>& used) {
  std::vector<bool> dropped(sights.size(), false);
  auto solved = fit_pose(from, lens, prior, sights, used);
  for (std::size_t round = 0; round < 3 * sights.size(); ++round) {
    const auto misfit = misfit_of(solved, used);
    std::optional<std::size_t> worst, best;
    double most = 1.0, least = 1.0;
    for (std::size_t i = 0; i < sights.size(); ++i) {
      const double rows = i < sights.landmarks.size() ? 2.0 : 1.0;
      const double found = contradiction(solved, i, used[i]).squared;
      // The others' own scatter, should the sigmas have been too hopeful; two numbers say nothing of scatter.
      const double rest = misfit.expected - (used[i] ? rows : 0.0);
      const double scatter = rest >= 2.0 ? (misfit.chi2 - (used[i] ? found : 0.0)) / rest : 1.0;
      const double share = found / (std::max(1.0, scatter) * (rows == 2.0 ? kContradicted2 : kContradicted1));
      if (used[i] && share > most) {
        most = share;
        worst = i;
      }
      if (!used[i] && !dropped[i] && share < least) {
        least = share;
        best = i;
      }
    }
    if (!worst && !best) break;
    if (worst) {
      used[*worst] = false;
      dropped[*worst] = true;
    } else {
      used[*best] = true;
    }
    solved = fit_pose(solved.model, lens, prior, sights, used);
  }
  return solved;
}

}  // namespace kasumi
