// One model of the sky fitted to the patches: its likeliest amount and exponent, how sure they are, and how much it
// leaves.
#pragma once

#include "estimator/sky_fit/sky_family.hpp"
#include "estimator/sky_fit/unexplained.hpp"

namespace kasumi {

struct FamilyFit {
  SkyAmount best;
  double squares = 0.0;                            // of the whitened residuals at the best
  std::array<double, kLightParts> part_squares{};  // of each part
  double brighter_ground = 0.0;                    // about which the doubts were laid out
  Eigen::VectorXd doubts;   // what the family supposes and the readings say otherwise, in standard deviations
  double log_volume = 0.0;  // ln of the share of the prior that explains the readings nearly as well
  Aerosol mean;             // over all amounts and exponents, by their probability
  AerosolCovariance covariance;
  double turbidity = 0.0, sigma_turbidity = 0.0;
  bool at_edge = false;
};

// A family's light at the patches, whitened once, so that any amount costs some thousand multiplications. Rows: part by
// part, patch by patch.
class WhitenedFamily {
 public:
  WhitenedFamily(const SkyFamily& family, const std::array<Eigen::MatrixXd, 3>& log_light,
                 std::span<const Direction> patches, const PartsOfLight& measured, const Unexplained& unexplained);

  // `known`: what is given of the aerosol.
  FamilyFit fitted(const GivenAir& known);

 private:
  // Of what is left when the doubts of the family take what they may, their own squares included.
  struct Squares {
    double sum = 0.0;
    Eigen::VectorXd left;             // without the doubts' share
    Eigen::VectorXd doubts;           // what they take, in standard deviations
    Eigen::MatrixXd freed;            // slopes by place and exponent, of what the doubts may take
    Eigen::Vector2d slope{0.0, 0.0};  // of half the sum
    Eigen::Matrix2d curvature;        // of that
  };
  Eigen::VectorXd left_at(const SkyAmount& amount) const;
  double sum_at(const SkyAmount& amount) const;
  Squares squares_at(const SkyAmount& amount) const;
  Eigen::Matrix2d slope_covariance(const Squares& squares) const;  // by the errors believed in
  void doubt_at(const SkyAmount& amount);
  double brighter_ground_ = 0.0;  // by which the doubts were laid out

  const SkyFamily& family_;
  const std::array<Eigen::MatrixXd, 3>& table_;
  std::span<const Direction> patches_;
  const Unexplained& unexplained_;
  double counted_;  // how often each independent value is among the patches: so much more does a prior count
  Eigen::VectorXd measured_;
  std::array<Eigen::MatrixXd, 3> light_;  // of each channel, by node
  Eigen::MatrixXd doubts_;
  Eigen::LDLT<Eigen::MatrixXd> doubt_squares_;
};

// ln(measured / model) at the patches, part by part, no gain taken; the family's doubts are.
PartsOfLight residuals_of(const SkyFamily& family, const FamilyFit& fit, std::span<const SkyPatch> patches,
                          const std::array<Eigen::MatrixXd, 3>& log_light);

}  // namespace kasumi
