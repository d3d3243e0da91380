// The aerosol in the air, for all rooms: its amount, how its extinction varies with wavelength, and its kind
// (docs/physics.md, section 12).
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace kasumi {

// Mixtures of particles (docs/sky.md). Single scattering albedo and phase function by wavelength belong to the
// kind.
enum class AerosolKind { continental, polluted, urban, maritime, desert, dust, smoke };
inline constexpr std::array kAerosolKinds{AerosolKind::continental, AerosolKind::polluted, AerosolKind::urban,
                                          AerosolKind::maritime,    AerosolKind::desert,   AerosolKind::dust,
                                          AerosolKind::smoke};
std::string_view name_of(AerosolKind kind);  // "continental"
std::optional<AerosolKind> aerosol_kind_named(std::string_view name);
// Angstrom exponent between 450 and 650 nm that the kind has by nature.
double natural_exponent(AerosolKind kind);
// Of two kinds, the other having this share of their depth at 550 nm.
double natural_exponent(AerosolKind kind, AerosolKind other, double other_share);

// Without aerosol (aod_550 = 0) the air is molecules alone.
struct Aerosol {
  double aod_550 = 0.1;  // optical depth at 550 nm of the whole column, from sea level upwards
  double angstrom_exponent = 1.3;
  AerosolKind kind = AerosolKind::continental;
  // What of the depth at 550 nm is of another kind: real air is seldom one mixture. Skies are of both (estimator/sky);
  // code that takes one kind takes the first.
  AerosolKind other = AerosolKind::continental;
  double other_share = 0.0;
  friend bool operator==(const Aerosol&, const Aerosol&) = default;
};
// aod_550 (wavelength / 550 nm)^-exponent
double optical_depth(const Aerosol& aerosol, double wavelength_nm);

// The aerosol thins out with altitude as e^(-h / height).
constexpr double kAerosolHeight_m = 1200.0;

// The papers' turbidity is the T whose optical depth at 1 um, .04608 T - .04586 (Preetham 1999, after Angstrom), the
// aerosol has.
double turbidity_of(const Aerosol& aerosol);
// The inverse; T below .9952 gives no aerosol.
Aerosol aerosol_of(double turbidity, double angstrom_exponent = 1.3, AerosolKind kind = AerosolKind::continental);

}  // namespace kasumi
