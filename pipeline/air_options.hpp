// --aod, --angstrom and --aerosol: the given air.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "estimator/given_air.hpp"

namespace CLI {
class App;
}

namespace kasumi {

// As typed.
struct AirOptions {
  std::optional<double> aod_550, angstrom_exponent;
  std::string kind;

  bool any() const { return aod_550 || describes_kind(); }
  bool describes_kind() const { return angstrom_exponent || !kind.empty(); }
  GivenAir given() const;
};

// --angstrom and --aerosol; each value is checked by itself.
void add_aerosol_options(CLI::App& command, AirOptions& options);
// The same and --aod. `words`: what --aod is for.
void add_air_options(CLI::App& command, AirOptions& options, const std::string& words);

}  // namespace kasumi
