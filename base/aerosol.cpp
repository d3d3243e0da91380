#include "base/aerosol.hpp"

#include <algorithm>
#include <cmath>

namespace kasumi {
namespace {

struct KindFacts {
  std::string_view name;
  double natural_exponent;
};
// In the order of AerosolKind. The exponents are those of fixtures/aerosol's Mie sums (a test compares them).
constexpr std::array<KindFacts, kAerosolKinds.size()> kFacts{{{"continental", 1.32},
                                                              {"polluted", 1.35},
                                                              {"urban", 1.34},
                                                              {"maritime", 0.10},
                                                              {"desert", 0.16},
                                                              {"dust", -0.12},
                                                              {"smoke", 1.83}}};
const KindFacts& facts_of(AerosolKind kind) {
  return kFacts[static_cast<std::size_t>(kind)];
}

}  // namespace

std::string_view name_of(AerosolKind kind) {
  return facts_of(kind).name;
}

std::optional<AerosolKind> aerosol_kind_named(std::string_view name) {
  for (const AerosolKind kind : kAerosolKinds)
    if (name == name_of(kind)) return kind;
  return std::nullopt;
}

double natural_exponent(AerosolKind kind) {
  return facts_of(kind).natural_exponent;
}

double natural_exponent(AerosolKind kind, AerosolKind other, double other_share) {
  constexpr double kBlue = 450.0 / 550.0, kRed = 650.0 / 550.0;
  const auto depth = [&](double wavelength) {
    return (1.0 - other_share) * std::pow(wavelength, -natural_exponent(kind)) +
           other_share * std::pow(wavelength, -natural_exponent(other));
  };
  return -std::log(depth(kRed) / depth(kBlue)) / std::log(kRed / kBlue);
}

double optical_depth(const Aerosol& aerosol, double wavelength_nm) {
  return aerosol.aod_550 * std::pow(wavelength_nm / 550.0, -aerosol.angstrom_exponent);
}

double turbidity_of(const Aerosol& aerosol) {
  return (optical_depth(aerosol, 1000.0) + 0.04586) / 0.04608;
}

Aerosol aerosol_of(double turbidity, double angstrom_exponent, AerosolKind kind) {
  const double at_1_um = std::max(0.0, 0.04608 * turbidity - 0.04586);
  return {at_1_um * std::pow(0.55, -angstrom_exponent), angstrom_exponent, kind};
}

}  // namespace kasumi
