// Merging the tables of two files, and writing tables as text.
#include <algorithm>
#include <sstream>

#include "base/table/config_table_file.hpp"

namespace kasumi {
namespace {

using Changes = std::map<std::string, std::optional<std::string>>;

toml::table changed(const toml::table& table, const std::string& prefix, const Changes& changes) {
  toml::table copy;
  for (const auto& [key, node] : table) {
    const std::string full = prefix + std::string(key.str());
    if (const auto change = changes.find(full); change != changes.end()) {
      if (change->second) copy.insert(key.str(), *change->second);
    } else if (const auto* inner = node.as_table()) {
      copy.insert(key.str(), changed(*inner, full + ".", changes));
    } else {
      copy.insert(key.str(), node);
    }
  }
  return copy;
}

}  // namespace

ConfigTable::Adopted ConfigTable::adopt(const ConfigTable& other, std::string_view table, const Rivals& rivals) const {
  Adopted adopted;
  const auto* theirs = other.file_->root[table].as_table();
  if (!theirs) return adopted;
  auto& root = file_->root;
  if (!root.contains(table)) root.insert(table, toml::table{});
  auto* ours = root[table].as_table();
  if (!ours) return adopted;  // not a table: the reader reports that
  const toml::table before = *ours;
  const auto said_here = [&](std::string_view key) {
    if (before.contains(key)) return true;
    for (const auto& set : rivals)
      if (set.contains(key) &&
          std::any_of(set.begin(), set.end(), [&](const auto& rival) { return before.contains(rival); }))
        return true;
    return false;
  };
  for (const auto& [key, node] : *theirs) {
    const auto full = fmt::format("{}.{}", table, key.str());
    if (said_here(key.str())) {
      adopted.overruled.push_back(full);
      continue;
    }
    ours->insert(key.str(), node);
    file_->adopted[full] = other.origin_of(full);
    adopted.gained.push_back(full);
  }
  return adopted;
}

std::string ConfigTable::copy_of(std::initializer_list<std::string_view> tables, const Changes& changes) const {
  toml::table copy;
  for (const auto name : tables) {
    if (const auto* table = file_->root[name].as_table())
      copy.insert(name, changed(*table, std::string(name) + ".", changes));
    if (const auto* array = file_->root[name].as_array()) copy.insert(name, *array);
  }
  std::ostringstream text;
  text << copy << "\n";
  return text.str();
}

}  // namespace kasumi
