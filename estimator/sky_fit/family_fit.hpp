// One model of the sky fitted to the patches: its likeliest amount and exponent, how sure they are, and how much it
// leaves.
#pragma once

#include "estimator/sky_fit/sky_family.hpp"
#include "estimator/sky_fit/unexplained.hpp"

namespace kasumi {

struct FamilyFit {
  FamilyPoint best;
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

// A family compared with the patches, all whitened. Rows: part by part, patch by patch.
class WhitenedFamily {
 public:
  WhitenedFamily(const SkyFamily& family, const FamilyTables& tables, std::span<const Direction> patches,
                 const RadianceParts& measured, const Unexplained& unexplained);

  // The nearest of some places, the doubts not asked.
  struct Look {
    FamilyPoint amount;
    double sum = 0.0;  // of squares, the prior included
  };
  Look look(const GivenAir& known, std::span<const FamilyPoint> places);
  // `known`: what is given of the aerosol. Searches the whole range first, or starts at `begin`.
  FamilyFit fitted(const GivenAir& known, std::span<const FamilyPoint> begin = {});
  // From what was found when errors were weighed otherwise.
  FamilyFit fitted_again(const GivenAir& known, const FamilyFit& before);

 private:
  using Unknowns = Eigen::Matrix<double, kSkyUnknowns, 1>;
  using OfUnknowns = Eigen::Matrix<double, kSkyUnknowns, kSkyUnknowns>;
  // Of what is left when the doubts of the family take what they may, their own squares included.
  struct Squares {
    double sum = 0.0;
    Eigen::VectorXd left;    // without the doubts' share
    Eigen::VectorXd doubts;  // what they take, in standard deviations
    Eigen::MatrixXd freed;   // slopes by the unknowns, of what the doubts may take
    Unknowns slope;          // of half the sum
    OfUnknowns curvature;    // of that
  };
  Eigen::MatrixXd whitened(const std::array<Eigen::MatrixXd, 3>& channels) const;
  Eigen::VectorXd left_at(const FamilyPoint& amount) const;
  double sum_of(const Eigen::VectorXd& left) const;
  Squares squares_at(const FamilyPoint& amount, const Eigen::VectorXd& left) const;
  OfUnknowns slope_covariance(const Squares& squares) const;  // under the assumed error model
  void doubt_at(const FamilyPoint& amount, const Eigen::VectorXd& left);
  void hold(const GivenAir& known);
  FamilyFit settled(const FamilyPoint& from, int layouts);
  void integrate(FamilyFit& fit, const OfUnknowns& width) const;

  // What is held: a number that is given, or that the family has not.
  bool is_free(int unknown) const { return free_[static_cast<std::size_t>(unknown)]; }
  FamilyPoint kept(FamilyPoint amount) const;
  // Half of it is the prior of tilt and share, and its derivative.
  double prior(const FamilyPoint& amount) const;
  Unknowns prior_slope(const FamilyPoint& amount) const;
  Unknowns stiffness() const;

  const SkyFamily& family_;
  const FamilyTables tables_;
  std::span<const Direction> patches_;
  const Unexplained& unexplained_;
  double counted_;  // how often each independent value is among the patches: so much more does a prior count
  Eigen::VectorXd measured_;
  std::array<bool, kSkyUnknowns> free_{};
  std::optional<double> given_exponent_;
  double given_place_ = 0.0;
  double brighter_ground_ = 0.0;  // about which the doubts are laid out
  Eigen::MatrixXd doubts_;
  Eigen::LDLT<Eigen::MatrixXd> doubt_squares_;
};

// ln(measured / model) at the patches, part by part, no gain taken; the family's doubts are.
RadianceParts residuals_of(const SkyFamily& family, const FamilyFit& fit, std::span<const ReadingPatch> patches,
                           const FamilyTables& tables);

}  // namespace kasumi
