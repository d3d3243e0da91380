// What a sky scanner measured: the light of the sky in some dozens of directions, as a table.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "estimator/sky_fit/sky_reading.hpp"

namespace kasumi {

struct ScanReadings {
  std::vector<SkyReading> readings;  // of every direction, that of the sun included
  bool colours = true;               // false: luminances alone
  std::string note;                  // for people: which columns were not used; empty: all were
};

// Columns `azimuth_deg` (clockwise from north), `elevation_deg`, and the light: `L` and a wavelength in nm each
// (`L380`, `L552.5`; W m-2 sr-1 nm-1), or `X`, `Y`, `Z` (CIE 1931), or `luminance`; any unit will do. Other columns are
// not used. Errors: bad_input, all problems together, with line and column.
Result<ScanReadings> read_scan_readings(const std::filesystem::path& file);

}  // namespace kasumi
