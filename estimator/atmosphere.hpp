// What the estimator knows about today's air and passes to the renderer.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/aerosol.hpp"
#include "base/clock.hpp"
#include "base/geometry.hpp"

namespace kasumi {

// Ratio of the optical thickness of haze and air to that of air alone (M Eq 5). 1 is pure air; the sky model is valid
// from 1.7 to 20.
struct Turbidity {
  double value = 2.0;
  friend constexpr auto operator<=>(Turbidity, Turbidity) = default;
};
// Where the sky model is valid.
constexpr Turbidity kLowestTurbidity{1.7};
constexpr Turbidity kHighestTurbidity{20.0};

using SunDirection = Direction;  // towards the sun, world frame

// How sure an aerosol is; all zero: it was given. The kind has no number for that.
struct AerosolCovariance {
  double aod_550 = 0.0;            // variance
  double aod_and_exponent = 0.0;   // covariance
  double angstrom_exponent = 0.0;  // variance
  friend bool operator==(const AerosolCovariance&, const AerosolCovariance&) = default;
};

// The state of the air (physics 12): the papers' T alone, or the aerosol itself, whose T is then turbidity_of() it.
class AirState {
 public:
  AirState() = default;
  AirState(Turbidity turbidity)  // NOLINT: T alone is the papers' air
      : turbidity_(turbidity), aerosol_(aerosol_of(turbidity.value)) {}
  AirState(const Aerosol& aerosol, const AerosolCovariance& covariance = {},  // NOLINT: an aerosol is air
           double near_ground = 1.0)
      : turbidity_{turbidity_of(aerosol)},
        aerosol_(aerosol),
        aerosol_known_(true),
        near_ground_(near_ground),
        covariance_(covariance) {}

  Turbidity turbidity() const { return turbidity_; }
  bool aerosol_known() const { return aerosol_known_; }
  // Where it is not known: continental aerosol with the optical depth that T stands for.
  const Aerosol& aerosol() const { return aerosol_; }
  const AerosolCovariance& covariance() const { return covariance_; }
  // Aerosol in the air between camera and object over what the column would have there, thinning as e^(-h/1200 m):
  // landmarks see the one, the sky the other. 1 unless both were seen.
  double near_ground() const { return near_ground_; }
  AirState with_near_ground(double near_ground) const {
    AirState air = *this;
    air.near_ground_ = near_ground;
    return air;
  }
  friend bool operator==(const AirState&, const AirState&) = default;

 private:
  Turbidity turbidity_;
  Aerosol aerosol_ = aerosol_of(Turbidity{}.value);
  bool aerosol_known_ = false;
  double near_ground_ = 1.0;
  AerosolCovariance covariance_;
};

enum class WeatherClass { pure_air, exceptionally_clear, very_clear, clear, light_haze, haze, fog };
std::string_view name_of(WeatherClass weather);  // "light haze"

enum class SkyCondition { clear, partly_cloudy, overcast, sun_too_low, night, covered_lens, unknown };
std::string_view name_of(SkyCondition condition);  // "partly cloudy"

// T and what goes with it, each under its own name.
struct AirQuality {
  Turbidity turbidity;
  double aod_550 = 0.0;       // of the aerosol, or by Angstrom of T
  double visibility_m = 0.0;  // meteorological range 3.912 / beta at 550 nm and the site's altitude
  WeatherClass weather = WeatherClass::clear;
  std::optional<Aerosol> aerosol;  // where it is known
};
AirQuality air_quality(const AirState& air, double altitude_m);

// The aerosol of the whole column, and all that is not sure of it.
struct FoundAerosol {
  Aerosol aerosol;                                   // the mean; its kind is the likeliest
  AerosolCovariance covariance;                      // the spread of kinds and sky models included
  std::array<double, kAerosolKinds.size()> kinds{};  // share of the depth that is likely of each; all 0: unknown
  double papers_share = 0.0;                         // probability that the sky is Preetham's, to which T alone belongs
};

// What one model of the clear sky makes of a picture.
struct ModelAnswer {
  std::string name;  // "preetham", "dome, continental", "hosek"
  Turbidity turbidity;
  double aod_550 = 0.0;
  double log_residual = 0.0;  // root mean square of ln(measured / model)
  double weight = 0.0;        // its probability among the models
};

// The result for one sky picture.
struct TurbidityEstimate {
  bool usable = false;
  std::string reason;  // for people: "rejected: 212 clear samples < 500 (clouds 81 %)"; empty when usable
  SkyCondition sky = SkyCondition::unknown;
  Turbidity turbidity;          // valid when usable
  double sigma = 0.0;           // standard deviation of T; valid when usable
  double clear_fraction = 0.0;  // of the sky that was examined
  int samples = 0;              // used in the fit
  double log_residual = 0.0;    // root mean square of ln(measured/model) over the inliers
  SunDirection sun{0.0, 0.0, 1.0};
  // Where several models were asked (ModelToFit::every_model); T and sigma then follow from the aerosol.
  std::optional<FoundAerosol> found;
  std::vector<ModelAnswer> models;  // the likeliest first
};

}  // namespace kasumi
