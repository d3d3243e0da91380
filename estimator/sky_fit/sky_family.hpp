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
#include "estimator/sky_fit/sky_doubts.hpp"
#include "estimator/sky_fit/sky_patches.hpp"

namespace kasumi {

// Cubics through four of the nodes (parabolas at the ends), the same for all places.
struct CubicTaps {
  int first = 0;
  std::array<double, 4> value{}, slope{};  // slope: by the place, a node's distance being 1
};
CubicTaps cubic_taps(double place, int nodes);

// What is to be found of a sky. Of Preetham's and Hosek's there is an amount alone.
struct SkyAmount {
  double place = 0.0;     // on the family's axis, in nodes
  double exponent = 0.0;  // of the dome's aerosol
};

class SkyFamily {
 public:
  static SkyFamily preetham(const SunDirection& sun);
  static SkyFamily dome(AerosolKind kind, double altitude_m, const SunDirection& sun);
  static SkyFamily hosek(std::shared_ptr<const HosekSky> sky, const SunDirection& sun);

  std::string name() const;
  std::optional<AerosolKind> kind() const { return kind_; }
  int nodes() const { return nodes_; }
  double natural_exponent() const { return kind_ ? kasumi::natural_exponent(*kind_) : 1.3; }

  Aerosol aerosol_at(const SkyAmount& amount) const;
  Turbidity turbidity_at(const SkyAmount& amount) const;
  double place_of(double aod_550) const;  // where the exponent is the natural one
  // d aod_550 / d place, at a fixed exponent
  double aod_slope(const SkyAmount& amount) const;

  // Linear sRGB, in a unit of the family's own.
  LightOfSky light(const SkyAmount& amount) const;
  // ln of it, [place of the sky][node], for each channel; at the natural exponent.
  std::array<Eigen::MatrixXd, 3> log_light(std::span<const Direction> directions) const;
  // ln light of one amount, by the table.
  std::array<Eigen::VectorXd, 3> log_light(const std::array<Eigen::MatrixXd, 3>& table, const SkyAmount& amount) const;
  // What the family supposes and cannot know; without columns where it supposes nothing.
  DoubtsOfLight doubts(const std::array<Eigen::MatrixXd, 3>& table, const SkyAmount& amount,
                       std::span<const Direction> directions, double brighter_ground) const;
  // The place from which each channel's light is taken, and its slopes.
  struct ChannelPlace {
    double place = 0.0, by_place = 1.0, by_exponent = 0.0;
  };
  std::array<ChannelPlace, 3> channel_places(const SkyAmount& amount) const;

 private:
  enum class Form { preetham, dome, hosek };
  SkyFamily(Form form, const SunDirection& sun) : form_(form), sun_(sun) {}
  double amount_at(double place) const;  // aod_550, or T

  Form form_;
  SunDirection sun_;
  std::optional<AerosolKind> kind_;
  double altitude_m_ = 0.0;
  glm::dvec3 on_ground_{0.0};  // the dome's light there, of some aerosol: linear sRGB, lux
  std::shared_ptr<const HosekSky> hosek_;
  // The axis: ln(amount + shift), evenly.
  int nodes_ = 0;
  double shift_ = 0.0, first_ = 0.0, step_ = 1.0;
};

}  // namespace kasumi
