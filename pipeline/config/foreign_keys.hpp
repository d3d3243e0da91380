// One file, several readers: what each leaves to the others.
#pragma once

#include <set>
#include <string_view>

#include "base/config_table.hpp"

namespace kasumi {

// For the root, by a reader of parts of a fixture's description, a kiosk's configuration or a calibration file: `own`
// are the tables it reads ("site", "sky", "scene", "landmarks"). All others are ignored whole; of its own, the keys
// that others read in them. What nobody knows stays a problem.
void ignore_what_others_read(const ConfigTable& root, const std::set<std::string_view>& own);

}  // namespace kasumi
