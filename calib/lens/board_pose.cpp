#include <cmath>

#include <Eigen/Dense>

#include "calib/lens/lens_fit.hpp"

namespace kasumi {

// A ray d sees the board's point (x, y) where d x (H (x, y, 1)) = 0, H = (r1, r2, t) up to scale: the homography of a
// plane, with rays in place of pixels.
std::optional<BoardPose> board_pose(std::span<const glm::dvec3> rays, std::span<const glm::dvec2> on_board) {
  if (rays.size() < 4 || rays.size() != on_board.size()) return std::nullopt;
  const auto count = static_cast<double>(rays.size());
  glm::dvec2 middle{0.0};
  for (const auto& at : on_board) middle += at / count;
  double spread = 0.0;
  for (const auto& at : on_board) spread += (std::abs(at.x - middle.x) + std::abs(at.y - middle.y)) / count;
  if (!(spread > 0.0)) return std::nullopt;

  Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Vector3d at((on_board[i].x - middle.x) / spread, (on_board[i].y - middle.y) / spread, 1.0);
    Eigen::Matrix3d across;
    across << 0.0, -rays[i].z, rays[i].y, rays[i].z, 0.0, -rays[i].x, -rays[i].y, rays[i].x, 0.0;
    Eigen::Matrix<double, 3, 9> rows;
    for (int k = 0; k < 3; ++k) rows.block<3, 3>(0, 3 * k) = at[k] * across;
    normal += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> eigen(normal);
  if (eigen.info() != Eigen::Success || eigen.eigenvalues()[1] <= 1e-12 * eigen.eigenvalues()[8]) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> best = eigen.eigenvectors().col(0);
  Eigen::Matrix3d h = Eigen::Map<const Eigen::Matrix3d>(best.data());

  const double size = 0.5 * (h.col(0).norm() + h.col(1).norm());
  if (!(size > 0.0)) return std::nullopt;
  h /= size;
  double ahead = 0.0;  // the rays point to the board, not away from it
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const Eigen::Vector3d at((on_board[i].x - middle.x) / spread, (on_board[i].y - middle.y) / spread, 1.0);
    ahead += Eigen::Vector3d(rays[i].x, rays[i].y, rays[i].z).dot(h * at);
  }
  if (ahead < 0.0) h = -h;
  Eigen::Matrix3d axes;
  axes << h.col(0), h.col(1), h.col(0).cross(h.col(1));
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(axes, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  const Eigen::Vector3d translation = spread * h.col(2) - rotation * Eigen::Vector3d(middle.x, middle.y, 0.0);
  if (!rotation.allFinite() || !translation.allFinite() || rotation.determinant() < 0.0) return std::nullopt;

  BoardPose pose;
  for (int column = 0; column < 3; ++column)
    pose.rotation[column] = {rotation(0, column), rotation(1, column), rotation(2, column)};
  pose.translation_m = {translation.x(), translation.y(), translation.z()};
  return pose;
}

}  // namespace kasumi
