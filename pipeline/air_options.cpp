#include "pipeline/air_options.hpp"

#include <CLI/CLI.hpp>

namespace kasumi {

GivenAir AirOptions::given() const {
  return {aod_550, angstrom_exponent, aerosol_kind_named(kind)};
}

void add_aerosol_options(CLI::App& command, AirOptions& options) {
  command
      .add_option("--angstrom", options.angstrom_exponent,
                  "Angstrom exponent of the aerosol; default: that of its kind, else 1.3")
      ->check(CLI::Range(kLowestGivenExponent, kHighestGivenExponent));
  std::vector<std::string> names;
  for (const AerosolKind kind : kAerosolKinds) names.emplace_back(name_of(kind));
  command.add_option("--aerosol", options.kind, "Kind of the aerosol; default: continental")
      ->check(CLI::IsMember(names));
}

void add_air_options(CLI::App& command, AirOptions& options, const std::string& words) {
  command.add_option("--aod", options.aod_550, words)->check(CLI::Range(0.0, kHighestGivenAod));
  add_aerosol_options(command, options);
}

}  // namespace kasumi
