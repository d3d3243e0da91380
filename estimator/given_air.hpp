// The air as given by a configuration or by a command's options; the rest is estimated, or taken as usual.
#pragma once

#include <optional>
#include <string>

#include "base/aerosol.hpp"
#include "estimator/atmosphere.hpp"

namespace kasumi {

// What may be given. No dome is hazier than the last optical depth.
constexpr double kHighestGivenAod = 1.8;
constexpr double kLowestGivenExponent = -0.5, kHighestGivenExponent = 2.5;

struct GivenAir {
  std::optional<double> aod_550;
  std::optional<double> angstrom_exponent;
  std::optional<AerosolKind> kind;
  friend bool operator==(const GivenAir&, const GivenAir&) = default;

  // Without any of the three the air is the papers': T alone.
  bool any() const { return aod_550 || angstrom_exponent || kind; }
  // Continental unless given, and with the kind's own exponent unless given; 1.3 where neither is.
  Aerosol with(double any_aod_550) const;
  std::optional<Aerosol> whole() const { return aod_550 ? std::optional(with(*aod_550)) : std::nullopt; }
  // Of which only the amount is to be found; empty: T alone is.
  std::optional<Aerosol> to_be_found() const { return any() ? std::optional(with(0.0)) : std::nullopt; }
  // Values given by `more` take precedence.
  GivenAir overridden_by(const GivenAir& more) const;
};

// For people: "aerosol optical depth 0.300 at 550 nm, exponent 1.32, continental (T 4.01)".
std::string text_of(const Aerosol& aerosol);
// For names of files: "T2.50", or "AOD0.300" where the aerosol is known.
std::string name_of(const AirState& air);

// The air of a turbidity, with an aerosol of exponent and kind as `like`; empty: T alone. `sigma`: of T.
AirState air_of(Turbidity turbidity, const std::optional<Aerosol>& like, double sigma = 0.0);

}  // namespace kasumi
