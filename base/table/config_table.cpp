#include "base/table/config_table.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "base/files.hpp"
#include "base/table/config_table_file.hpp"
#include "base/table/key_depth.hpp"
#include "base/words/nearest_word.hpp"

namespace kasumi {

namespace {

const toml::table kEmptyTable;
constexpr int kDeepestKey = 16;  // parts; Kasumi's files have 4 at most

std::string shown(const toml::node& node) {
  if (const auto* number = node.as_floating_point())
    return fmt::format("{}", number->get());  // 134.7, not 134.69999999999999
  std::ostringstream out;
  node.visit([&](const auto& value) { out << value; });
  auto text = out.str();
  if (text.size() > 80) text = text.substr(0, 77) + "...";
  return text;
}

std::string describe(Range range, std::string_view noun) {
  const bool low = std::isfinite(range.lowest), high = std::isfinite(range.highest);
  if (low && high) return fmt::format("{} from {} to {}", noun, range.lowest, range.highest);
  if (low) return fmt::format("{} >= {}", noun, range.lowest);
  if (high) return fmt::format("{} <= {}", noun, range.highest);
  return std::string(noun);
}

// By the keys that were read of the same table.
std::string meant_key(const std::string& key, const std::set<std::string>& read) {
  const auto dot = key.rfind('.');
  const auto table = key.substr(0, dot == std::string::npos ? 0 : dot + 1);
  std::vector<std::string> beside;
  for (const auto& other : read)
    if (other.starts_with(table) && other.find('.', table.size()) == std::string::npos)
      beside.push_back(other.substr(table.size()));
  return did_you_mean(key.substr(table.size()), beside);
}

bool inside(double value, Range range) {
  return std::isfinite(value) && value >= range.lowest && value <= range.highest;
}

// The keys below a node of that full key: of a table, or of a list of tables.
void list_keys_below(const toml::node& node, const std::string& full, std::vector<std::string>& keys);

void list_keys(const toml::table& table, const std::string& prefix, std::vector<std::string>& keys) {
  for (const auto& [key, node] : table) {
    keys.push_back(prefix + std::string(key.str()));
    list_keys_below(node, std::string(keys.back()), keys);
  }
}

void list_keys_below(const toml::node& node, const std::string& full, std::vector<std::string>& keys) {
  if (const auto* inner = node.as_table()) list_keys(*inner, full + ".", keys);
  if (const auto* array = node.as_array(); array && array->is_array_of_tables())
    for (std::size_t i = 0; i < array->size(); ++i)
      list_keys(*(*array)[i].as_table(), fmt::format("{}[{}].", full, i), keys);
}

}  // namespace

Result<ConfigTable> ConfigTable::read_file(const std::filesystem::path& path) {
  auto text = read_text_file(path, kSmallFile);
  if (!text) return fail(text.error());
  return parse(*text, path);
}

std::filesystem::path ConfigTable::place_of_copy(const std::filesystem::path& path,
                                                 const std::filesystem::path& copies) {
  return copies / std::filesystem::absolute(path).lexically_normal().relative_path();
}

Result<ConfigTable> ConfigTable::read_copy(const std::filesystem::path& path, const std::filesystem::path& copies) {
  const auto text = read_text_file(place_of_copy(path, copies), kSmallFile);
  if (!text) return fail(text.error());
  auto table = parse(*text, path);
  if (table) table->file_->copies = copies;
  return table;
}

Result<ConfigTable> ConfigTable::parse(std::string_view text, const std::filesystem::path& name) {
  if (const int depth = deepest_key(text); depth > kDeepestKey)
    return fail(FaultKind::bad_input, "{}: a key of {} parts: expected {} at most", name.string(), depth, kDeepestKey);
  auto file = std::make_shared<File>();
  file->path = name;
  try {
    file->root = toml::parse(text, name.string());
  } catch (const toml::parse_error& error) {
    const auto at = error.source().begin;
    return fail(FaultKind::bad_input, "{}:{}:{}: not valid TOML: {}", name.string(), at.line, at.column,
                error.description());
  }
  auto node = std::make_shared<Node>(Node{&file->root, ""});
  return ConfigTable(std::move(file), std::move(node));
}

std::string ConfigTable::full_key(std::string_view key) const {
  return node_->prefix + std::string(key);
}

// The file of the key itself, or of the key it lies below.
const std::filesystem::path& ConfigTable::origin_of(const std::string& full) const {
  for (auto end = full.size(); end != std::string::npos; end = end == 0 ? std::string::npos : full.rfind('.', end - 1))
    if (const auto found = file_->adopted.find(full.substr(0, end)); found != file_->adopted.end())
      return found->second;
  return file_->path;
}

bool ConfigTable::has(std::string_view key) const {
  return node_->table->contains(key);
}

void ConfigTable::problem(std::string_view key, std::string_view expected) const {
  if (node_->missing) return;
  const auto* node = node_->table->get(key);
  const auto full = full_key(key);
  const auto file = origin_of(full).string();
  const auto named = file_->files.find(full);
  if (named != file_->files.end() && named->second.extension() == ".toml")
    file_->unread.insert(full.substr(0, full.find_first_of(".[")));
  if (node)
    file_->problems.add("{}: {} = {}: expected {}", file, full, shown(*node), expected);
  else if (!file_->missing_excused)
    file_->problems.add("{}: {} is missing: expected {}", file, full, expected);
}

double ConfigTable::number(std::string_view key, Range range, std::optional<double> fallback) const {
  file_->read.insert(full_key(key));
  const auto* node = node_->table->get(key);
  if (!node && fallback) return *fallback;
  const auto value = node ? node->value<double>() : std::nullopt;
  if (value && node->is_number() && inside(*value, range)) return *value;
  problem(key, describe(range, "a number"));
  return fallback.value_or(std::isfinite(range.lowest) ? range.lowest : 0.0);
}

int ConfigTable::integer(std::string_view key, Range range, std::optional<int> fallback) const {
  file_->read.insert(full_key(key));
  const auto* node = node_->table->get(key);
  if (!node && fallback) return *fallback;
  range.lowest = std::max(range.lowest, double{std::numeric_limits<int>::min()});
  range.highest = std::min(range.highest, double{std::numeric_limits<int>::max()});
  if (node && node->is_integer()) {
    const auto value = node->value<std::int64_t>();
    if (value && inside(static_cast<double>(*value), range)) return static_cast<int>(*value);
  }
  problem(key, describe(range, "a whole number"));
  return fallback.value_or(0);
}

bool ConfigTable::flag(std::string_view key, std::optional<bool> fallback) const {
  file_->read.insert(full_key(key));
  const auto* node = node_->table->get(key);
  if (!node && fallback) return *fallback;
  if (node && node->is_boolean()) return *node->value<bool>();
  problem(key, "true or false");
  return fallback.value_or(false);
}

std::string ConfigTable::text(std::string_view key, std::optional<std::string> fallback) const {
  file_->read.insert(full_key(key));
  const auto* node = node_->table->get(key);
  if (!node && fallback) return *fallback;
  if (node && node->is_string()) return *node->value<std::string>();
  problem(key, "a text in quotes");
  return fallback.value_or("");
}

std::string ConfigTable::choice(std::string_view key, std::initializer_list<std::string_view> words,
                                std::optional<std::string> fallback) const {
  file_->read.insert(full_key(key));
  const auto* node = node_->table->get(key);
  if (!node && fallback) return *fallback;
  if (node && node->is_string()) {
    const auto value = *node->value<std::string>();
    if (std::find(words.begin(), words.end(), value) != words.end()) return value;
  }
  const auto typed = node && node->is_string() ? *node->value<std::string>() : std::string();
  problem(key, fmt::format("one of \"{}\"{}", fmt::join(words, "\", \""),
                           did_you_mean(typed, std::vector<std::string>(words.begin(), words.end()))));
  return fallback.value_or(std::string(*words.begin()));
}

std::vector<double> ConfigTable::numbers(std::string_view key, std::size_t count, Range range,
                                         std::optional<std::vector<double>> fallback) const {
  file_->read.insert(full_key(key));
  const auto* node = node_->table->get(key);
  if (!node && fallback) return *fallback;
  std::vector<double> values;
  if (const auto* array = node ? node->as_array() : nullptr) {
    for (const auto& element : *array) {
      const auto value = element.is_number() ? element.value<double>() : std::nullopt;
      if (value && inside(*value, range)) values.push_back(*value);
    }
    if (values.size() == array->size() && !values.empty() && (count == 0 || values.size() == count)) return values;
  }
  const auto noun = count == 0 ? std::string("a list of numbers") : fmt::format("a list of {} numbers", count);
  problem(key, describe(range, noun));
  return fallback.value_or(std::vector<double>(count, 0.0));
}

std::vector<std::string> ConfigTable::texts(std::string_view key) const {
  file_->read.insert(full_key(key));
  std::vector<std::string> values;
  const auto* node = node_->table->get(key);
  if (!node) return values;
  const auto* array = node->as_array();
  if (array)
    for (const auto& element : *array)
      if (element.is_string()) values.push_back(*element.value<std::string>());
  if (!array || values.size() != array->size()) problem(key, "a list of texts in quotes");
  return values;
}

std::vector<std::string> ConfigTable::keys() const {
  std::vector<std::string> keys;
  for (const auto& [key, node] : *node_->table) keys.emplace_back(key.str());
  return keys;
}

std::optional<double> ConfigTable::if_number(std::string_view key) const {
  file_->read.insert(full_key(key));
  const auto* node = node_->table->get(key);
  const auto value = node && node->is_number() ? node->value<double>() : std::nullopt;
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::string> ConfigTable::if_text(std::string_view key) const {
  file_->read.insert(full_key(key));
  const auto* node = node_->table->get(key);
  return node && node->is_string() ? node->value<std::string>() : std::nullopt;
}

Utc ConfigTable::utc(std::string_view key) const {
  file_->read.insert(full_key(key));
  const auto* node = node_->table->get(key);
  const auto* value = node ? node->as_date_time() : nullptr;
  if (!value || !(*value)->offset) {
    problem(key, "a date and time with offset like 2026-06-21T03:00:00Z");
    return {};
  }
  const toml::date_time& at = **value;
  const std::chrono::year_month_day date{std::chrono::year{at.date.year}, std::chrono::month{at.date.month},
                                         std::chrono::day{at.date.day}};
  // Nanoseconds since 1970 fill 64 bits in the year 2262.
  if (at.date.year < 1970 || at.date.year > 2261) {
    problem(key, "a date from 1970 to 2261");
    return {};
  }
  return std::chrono::sys_days{date} + std::chrono::hours{at.time.hour} + std::chrono::minutes{at.time.minute} +
         std::chrono::seconds{at.time.second} + std::chrono::nanoseconds{at.time.nanosecond} -
         std::chrono::minutes{at.offset->minutes};
}

std::optional<Utc> ConfigTable::optional_utc(std::string_view key) const {
  file_->read.insert(full_key(key));
  if (!has(key)) return std::nullopt;
  return utc(key);
}

std::optional<std::filesystem::path> ConfigTable::optional_file(std::string_view key) const {
  file_->read.insert(full_key(key));
  if (!has(key)) return std::nullopt;
  return file(key);
}

std::filesystem::path ConfigTable::file(std::string_view key) const {
  const auto name = text(key);
  if (name.empty()) return {};
  auto path = origin_of(full_key(key)).parent_path() / name;
  std::error_code error;
  if (!file_->copies.empty())
    if (auto copy = place_of_copy(path, file_->copies); std::filesystem::is_regular_file(copy, error))
      path = std::move(copy);
  file_->files[full_key(key)] = path;
  if (!std::filesystem::is_regular_file(path, error))
    problem(key, fmt::format("an existing file (looked for {})", path.string()));
  return path;
}

ConfigTable ConfigTable::table(std::string_view key) const {
  if (auto found = optional_table(key)) return *found;
  if (!has(key)) problem(key, fmt::format("a table [{}]", full_key(key)));
  return ConfigTable(file_, std::make_shared<Node>(Node{&kEmptyTable, full_key(key) + ".", true}));
}

std::optional<ConfigTable> ConfigTable::optional_table(std::string_view key) const {
  file_->read.insert(full_key(key));
  const auto* node = node_->table->get(key);
  if (!node) return std::nullopt;
  if (const auto* inner = node->as_table())
    return ConfigTable(file_, std::make_shared<Node>(Node{inner, full_key(key) + "."}));
  problem(key, fmt::format("a table [{}]", full_key(key)));
  return std::nullopt;
}

std::vector<ConfigTable> ConfigTable::tables(std::string_view key) const {
  file_->read.insert(full_key(key));
  std::vector<ConfigTable> result;
  const auto* node = node_->table->get(key);
  if (!node) return result;
  const auto* array = node->as_array();
  if (!array || !array->is_array_of_tables()) {
    problem(key, fmt::format("tables [[{}]]", full_key(key)));
    return result;
  }
  for (std::size_t i = 0; i < array->size(); ++i)
    result.push_back(ConfigTable(
        file_, std::make_shared<Node>(Node{(*array)[i].as_table(), fmt::format("{}[{}].", full_key(key), i)})));
  return result;
}

void ConfigTable::ignore(std::string_view key) const {
  const std::string full = full_key(key);
  file_->read.insert(full);
  std::vector<std::string> below;
  if (const auto* node = node_->table->get(key)) list_keys_below(*node, full, below);
  file_->read.insert(below.begin(), below.end());
}

void ConfigTable::excuse_missing() const {
  file_->missing_excused = true;
}

const std::filesystem::path& ConfigTable::path() const {
  return file_->path;
}

std::filesystem::path ConfigTable::folder() const {
  return file_->path.parent_path();
}

std::set<std::string> ConfigTable::keys_asked() const {
  return file_->read;
}

std::map<std::string, std::filesystem::path> ConfigTable::files_asked() const {
  return file_->files;
}

Result<> ConfigTable::finish() const {
  std::vector<std::string> keys;
  list_keys(file_->root, "", keys);
  std::string skipped;  // keys inside an unknown table need no line of their own
  for (const auto& key : keys) {
    if (file_->read.contains(key)) continue;
    if (file_->unread.contains(key.substr(0, key.find_first_of(".[")))) continue;
    if (!skipped.empty() && key.starts_with(skipped)) continue;
    file_->problems.add("{}: {}: unknown key{}", origin_of(key).string(), key, meant_key(key, file_->read));
    skipped = key + ".";
  }
  if (file_->problems.empty()) return {};
  return fail(file_->problems.fault());
}

}  // namespace kasumi
