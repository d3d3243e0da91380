// One file has several readers: the keys that each leaves to the others.
#pragma once

#include <set>
#include <string_view>

#include "base/table/config_table.hpp"

namespace kasumi {

// For a reader of only some keys of a fixture's description, a kiosk's configuration or a calibration file. `own`: the
// tables it reads ("site", "sky", "scene", "landmarks"). Ignores in them the keys that other readers know; keys that no
// reader knows stay a problem.
void ignore_keys_of_others(const ConfigTable& root, const std::set<std::string_view>& own);
// The same, and all other tables.
void ignore_what_others_read(const ConfigTable& root, const std::set<std::string_view>& own);

}  // namespace kasumi
