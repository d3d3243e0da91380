#include "estimator/given_air.hpp"

#include <fmt/format.h>

namespace kasumi {

Aerosol GivenAir::with(double any_aod_550) const {
  Aerosol aerosol;
  aerosol.aod_550 = any_aod_550;
  if (kind) {
    aerosol.kind = *kind;
    aerosol.angstrom_exponent = natural_exponent(*kind);
  }
  if (angstrom_exponent) aerosol.angstrom_exponent = *angstrom_exponent;
  return aerosol;
}

GivenAir GivenAir::overridden_by(const GivenAir& more) const {
  GivenAir both = more;
  if (!both.aod_550) both.aod_550 = aod_550;
  if (!both.angstrom_exponent) both.angstrom_exponent = angstrom_exponent;
  if (!both.kind) both.kind = kind;
  return both;
}

std::string text_of(const Aerosol& aerosol) {
  return fmt::format("aerosol optical depth {:.3f} at 550 nm, exponent {:.2f}, {} (T {:.2f})", aerosol.aod_550,
                     aerosol.angstrom_exponent, name_of(aerosol.kind), turbidity_of(aerosol));
}

std::string name_of(const AirState& air) {
  return air.aerosol_known() ? fmt::format("AOD{:.3f}", air.aerosol().aod_550)
                             : fmt::format("T{:.2f}", air.turbidity().value);
}

AirState air_of(Turbidity turbidity, const std::optional<Aerosol>& like, double sigma) {
  if (!like) return turbidity;
  const Aerosol aerosol = aerosol_of(turbidity.value, like->angstrom_exponent, like->kind);
  // The optical depth is linear in T; the exponent is as given.
  const double aod_sigma = sigma * (aerosol_of(turbidity.value + 1.0, like->angstrom_exponent).aod_550 -
                                    aerosol_of(turbidity.value, like->angstrom_exponent).aod_550);
  return {aerosol, {aod_sigma * aod_sigma, 0.0, 0.0}};
}

}  // namespace kasumi
