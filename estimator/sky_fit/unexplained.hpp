// What no model of the sky explains of the readings: the instrument's own errors, and how far a real sky differs from
// any model, smoothly over the sky and from patch to patch. A fit weighs readings by it and takes its sigma from it.
#pragma once

#include <array>
#include <span>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "estimator/sky_fit/reading_patches.hpp"
#include "estimator/sky_fit/sky_fit.hpp"

namespace kasumi {

// ln light in three parts that err on their own: its mean over red, green and blue; red over blue; green over both.
constexpr int kLightParts = 3;
constexpr std::array<std::array<double, 3>, kLightParts> kPartsOfChannels{
    {{1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0}, {1.0, 0.0, -1.0}, {-0.5, 1.0, -0.5}}};

using RadianceParts = std::array<Eigen::VectorXd, kLightParts>;  // [place of the sky]
RadianceParts parts_of(std::span<const ReadingPatch> patches);

// Standard deviations of ln light.
struct UnexplainedScale {
  double smooth = 0.03;  // alike within some half radian, and at the same distance from the sun
  double rough = 0.01;   // from patch to patch
};

class Unexplained {
 public:
  Unexplained(std::span<const ReadingPatch> patches, const InstrumentDoubt& doubt);

  int parts() const { return parts_; }
  const UnexplainedScale& scale(int part) const { return scales_[static_cast<std::size_t>(part)]; }
  // The likeliest scales where a model leaves these residuals; patches that lie far off their neighbours count less
  // from now on.
  void learn(const RadianceParts& residuals);

  // The number of independent values in the smooth errors of one part.
  double independent() const;

  // L^-1 of the covariance L L^T by which patches are weighed. It takes errors for rougher than they are: a fit that
  // trusts in their smoothness leans on the finest differences between patches, which no model has right.
  template <class Columns>
  void whiten(int part, Columns& columns) const {
    // One by one, where they are few: Eigen then spends more on laying out the factor than on solving.
    constexpr Eigen::Index kFew = 8;
    if (columns.cols() > kFew) {
      factors_[static_cast<std::size_t>(part)].matrixL().solveInPlace(columns);
      return;
    }
    for (Eigen::Index k = 0; k < columns.cols(); ++k) {
      auto column = columns.col(k);
      if (column.isZero(0.0)) continue;  // of what is held
      factors_[static_cast<std::size_t>(part)].matrixL().solveInPlace(column);
    }
  }
  // Covariance of whitened columns under the assumed smooth errors: A^T M A, where M is the identity if errors are as
  // rough as the weights assume.
  Eigen::MatrixXd believed(int part, Eigen::MatrixXd columns) const;

 private:
  Eigen::MatrixXd covariance(int part, const UnexplainedScale& scale) const;
  void factorise();

  int parts_ = kLightParts;
  Eigen::MatrixXd alike_;                                // correlation of what is smooth
  std::array<Eigen::MatrixXd, kLightParts> instrument_;  // its covariance, gains included
  std::array<Eigen::VectorXd, kLightParts> noise_;       // variances
  Eigen::VectorXd off_;                                  // variance of ln light of patches that are not sky
  std::array<UnexplainedScale, kLightParts> scales_;
  std::array<Eigen::LLT<Eigen::MatrixXd>, kLightParts> factors_;
};

}  // namespace kasumi
