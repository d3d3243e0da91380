// The hills around the virtual building.
#pragma once

#include "base/table/config_table.hpp"
#include "estimator/light/skyline.hpp"

namespace kasumi {

// `skyline` of [object]: a table (CSV) with columns azimuth_deg, from north clockwise, and elevation_deg, at least two
// rows; level without the key. Problems are collected in the table's file.
Skyline read_skyline(const ConfigTable& object);

}  // namespace kasumi
