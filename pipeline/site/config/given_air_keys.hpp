// The keys of [site] that say what is known of the air: aod_550, angstrom_exponent, aerosol.
#pragma once

#include "base/table/config_table.hpp"
#include "estimator/given_air.hpp"

namespace kasumi {

// Each a value or "auto", which is as good as missing.
GivenAir read_given_air(const ConfigTable& site);

}  // namespace kasumi
