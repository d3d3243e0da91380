// One model of the clear sky as a fit sees it: ln of light as a smooth function of an amount, the same at all places.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <Eigen/Core>

#include "estimator/atmosphere.hpp"
#include "estimator/sky/site_sky.hpp"
#include "estimator/sky_fit/reading_patches.hpp"
#include "estimator/sky_fit/sky_doubts.hpp"

namespace kasumi {

// Cubics through four of the nodes (parabolas at the ends), the same for all places.
struct CubicTaps {
  int first = 0;
  std::array<double, 4> value{}, slope{};  // slope: by the place, a node's distance being 1
};
CubicTaps cubic_taps(double place, int nodes);

// What is to be found of a sky. Of Preetham's and Hosek's there is an amount alone.
struct FamilyPoint {
  double place = 0.0;  // on the family's axis, in nodes
  double tilt = 0.0;   // exponent of the dome's aerosol over the one that its particles have by nature
  double share = 0.0;  // of a blend's other kind
};
// The same three as columns.
constexpr int kPlace = 0, kTilt = 1, kShare = 2, kSkyUnknowns = 3;

// ln of linear sRGB, [place of the sky][node], for each channel; at the natural exponent.
using LightTable = std::array<Eigen::MatrixXd, 3>;
// Of both kinds of a blend; of every other family the second is null.
struct FamilyTables {
  const LightTable* one = nullptr;
  const LightTable* other = nullptr;
};

class SkyFamily {
 public:
  static SkyFamily preetham(const SunDirection& sun);
  static SkyFamily dome(AerosolKind kind, double altitude_m, const SunDirection& sun);
  // Of two domes of one site and sun.
  static SkyFamily blend(const SkyFamily& one, const SkyFamily& other);
  static SkyFamily hosek(std::shared_ptr<const HosekSky> sky, const SunDirection& sun);

  std::string name() const;
  std::optional<AerosolKind> kind() const { return kind_; }    // the dome's; of a blend the one
  std::optional<AerosolKind> other() const { return other_; }  // of a blend
  int nodes() const { return nodes_; }
  double natural_exponent(double share = 0.0) const;

  Aerosol aerosol_at(const FamilyPoint& amount) const { return aerosol_at(amount, natural_exponent(amount.share)); }
  Aerosol aerosol_at(const FamilyPoint& amount, double natural_exponent) const;     // the exponent of that share
  Turbidity turbidity_of(const FamilyPoint& amount, const Aerosol& aerosol) const;  // aerosol: of that amount
  double place_of(double aod_550) const;  // where the exponent is the natural one

  // Linear sRGB, in a unit of the family's own.
  RadianceField light(const FamilyPoint& amount) const;
  // Not of a blend, whose kinds have tables.
  LightTable log_light(std::span<const Direction> directions) const;
  // ln light of one amount, by the tables, and its slopes by the three unknowns, [place of the sky][unknown].
  std::array<Eigen::VectorXd, 3> log_light(const FamilyTables& tables, const FamilyPoint& amount) const;
  std::array<Eigen::MatrixXd, 3> slopes(const FamilyTables& tables, const FamilyPoint& amount) const;
  // What the family supposes and cannot know; without columns where it supposes nothing.
  RadianceDoubts doubts(const FamilyTables& tables, const FamilyPoint& amount, std::span<const Direction> directions,
                        double brighter_ground) const;

 private:
  enum class Form { preetham, dome, hosek };
  SkyFamily(Form form, const SunDirection& sun) : form_(form), sun_(sun) {}
  double amount_at(double place) const;  // aod_550, or T

  Form form_;
  SunDirection sun_;
  // What a channel takes from one kind's table: from where, how much of its light, and the slopes of both.
  struct Tap {
    double place = 0.0, weight = 1.0;
    std::array<double, kSkyUnknowns> place_by{1.0, 0.0, 0.0};
    double weight_by_share = 0.0;
  };
  std::array<Tap, 2> taps(std::size_t channel, const FamilyPoint& amount) const;

  std::optional<AerosolKind> kind_, other_;
  double altitude_m_ = 0.0;
  glm::dvec3 on_ground_{0.0};  // the dome's light there, of some aerosol: linear sRGB, lux
  std::shared_ptr<const HosekSky> hosek_;
  // The axis: ln(amount + shift), evenly.
  int nodes_ = 0;
  double shift_ = 0.0, first_ = 0.0, step_ = 1.0;
};

}  // namespace kasumi
