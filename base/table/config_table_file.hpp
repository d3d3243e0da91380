// What ConfigTable stores about its file. Only for ConfigTable's own sources.
#pragma once

#include <toml++/toml.h>

#include "base/table/config_table.hpp"

namespace kasumi {

struct ConfigTable::File {
  std::filesystem::path path;
  toml::table root;
  Problems problems;
  std::set<std::string> read;  // full keys that were read
  std::map<std::string, std::filesystem::path> files;
  std::map<std::string, std::filesystem::path> adopted;  // full keys, and the file each came from
  std::filesystem::path copies;  // a folder in which named files are looked for first; empty: none
  // Top tables in which a named table is missing or refused, so that their other keys may not have been read.
  std::set<std::string> unread;
  bool missing_excused = false;
};

struct ConfigTable::Node {
  const toml::table* table;  // inside File::root, or the empty table for a missing one
  std::string prefix;        // "sky.lens." or ""
  bool missing = false;      // already reported: its keys add no problems
};

}  // namespace kasumi
