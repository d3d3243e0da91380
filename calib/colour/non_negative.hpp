// Least squares whose unknowns must not be negative.
#pragma once

#include <Eigen/Core>

namespace kasumi {

// The x that makes x' matrix x / 2 - pull' x least, the first `bounded` of its elements nowhere negative. Matrix:
// symmetric, positive definite. Block principal pivoting (Kim and Park 2011) with Murty's rule as its way out, so that
// it ends.
struct NonNegative {
  Eigen::VectorXd x;
  Eigen::Array<bool, Eigen::Dynamic, 1> held;  // at 0, by the bound
};
NonNegative least_non_negative(const Eigen::MatrixXd& matrix, const Eigen::VectorXd& pull, Eigen::Index bounded);

// Covariance of x when matrix is its information; what is held at 0 has none.
Eigen::MatrixXd covariance_of(const Eigen::MatrixXd& matrix, const NonNegative& solved);

}  // namespace kasumi
