#include "calib/colour/non_negative.hpp"

#include <vector>

#include <Eigen/Cholesky>

namespace kasumi {
namespace {

std::vector<Eigen::Index> free_of(const NonNegative& solved) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index i = 0; i < solved.held.size(); ++i)
    if (!solved.held[i]) free.push_back(i);
  return free;
}

}  // namespace

NonNegative least_non_negative(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& pull, Eigen::Index bounded) {
  const Eigen::Index size = pull.size();
  NonNegative solved{Eigen::VectorXd::Zero(size), Eigen::Array<bool, Eigen::Dynamic, 1>::Constant(size, false)};
  const double slack = 1e-12 * pull.cwiseAbs().maxCoeff();
  Eigen::Index fewest = size + 1;
  int patience = 3;
  constexpr int kRounds = 1000;
  for (int round = 0; round < kRounds; ++round) {
    const auto free = free_of(solved);
    solved.x.setZero();
    const Eigen::MatrixXd part = matrix(free, free);
    const Eigen::VectorXd wanted = pull(free);
    const Eigen::VectorXd least = part.llt().solve(wanted);
    solved.x(free) = least;
    const Eigen::VectorXd slope = matrix * solved.x - pull;
    std::vector<Eigen::Index> wrong;
    for (Eigen::Index i = 0; i < bounded; ++i)
      if (solved.held[i] ? slope[i] < -slack : solved.x[i] < 0.0) wrong.push_back(i);
    if (wrong.empty()) return solved;
    const auto count = static_cast<Eigen::Index>(wrong.size());
    if (count < fewest) {
      fewest = count;
      patience = 3;
    } else if (patience > 0) {
      --patience;
    } else {
      wrong.erase(wrong.begin(), wrong.end() - 1);
    }
    for (const auto i : wrong) solved.held[i] = !solved.held[i];
  }
  solved.x.head(bounded) = solved.x.head(bounded).cwiseMax(0.0);
  return solved;
}

Eigen::MatrixXd covariance_of(const Eigen::MatrixXd& matrix, const NonNegative& solved) {
  const auto free = free_of(solved);
  const auto count = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(matrix.rows(), matrix.cols());
  const Eigen::MatrixXd part = matrix(free, free);
  const Eigen::MatrixXd inverse = part.llt().solve(Eigen::MatrixXd::Identity(count, count));
  covariance(free, free) = inverse;
  return covariance;
}

}  // namespace kasumi
