// The data behind dome(): one row per kind and amount of aerosol, altitude and sun. dome_table.bin is made by
// kasumi-make-dome-table and linked as it is (dome_table.S).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/aerosol.hpp"
#include "base/sky/dome_function.hpp"

namespace kasumi {

// The file is 16-bit numbers, little endian: version; how many kinds, altitudes, amounts and suns; ground steepness *
// 100; steepness scale [m]; altitudes [m]; aod_550 * 10000; sun zenith angles [deg] * 100; three lobes * 1000; rows.
//
// A row, for X, Y, Z each: ln of the sky's mean light * 2000; ln of the sun's illuminance [lux] * 1000; ln of the
// largest coefficient * 1000; then kDomeAngles * kDomePowers coefficients, each stored as n = coefficient / largest *
// 32000. They describe light over its mean by Chebyshev polynomials of u stretched over -1 .. 1, angle by angle.
constexpr int kDomeRowHead = 3;
constexpr int kDomeRow = 3 * (kDomeRowHead + kDomeAngles * kDomePowers);
constexpr double kDomeMeanSteps = 2000.0, kDomeLogSteps = 1000.0, kDomeCoefficientSteps = 32000.0;

struct DomeTable {
  int version = 0;
  std::vector<double> altitudes_m, aods_550, sun_zeniths_deg;
  double ground_steepness = 0.0, steepness_scale_m = 1.0;  // steepness = ground_steepness * e^{altitude / scale}
  std::array<double, 3> lobes{};
  std::span<const std::int16_t> rows;  // [kind][altitude][aod][sun]
};
const DomeTable& dome_table();

}  // namespace kasumi
