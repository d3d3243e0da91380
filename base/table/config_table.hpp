// Strict reading of a TOML file: every problem names file, key, value and what was expected, and all problems are
// collected before reading fails.
#pragma once

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"

namespace kasumi {

struct Range {
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
};

// One table of the file. Copies are cheap and share the list of problems and the set of keys that were read.
// A getter that finds an error adds a problem and returns the fallback (or zero, empty), so that reading can continue.
class ConfigTable {
 public:
  // Fails when the file cannot be read or is not TOML (message with line and column).
  static Result<ConfigTable> read_file(const std::filesystem::path& path);
  // Reads the copy of it, and the copies of all files it names, that lie below the folder `copies` by their whole names.
  // Names in problems, and folders, stay those of the file itself.
  static Result<ConfigTable> read_copy(const std::filesystem::path& path, const std::filesystem::path& copies);
  static Result<ConfigTable> parse(std::string_view text, const std::filesystem::path& name);

  bool has(std::string_view key) const;
  // Required when no fallback is given. Numbers must be finite and inside the range, bounds included.
  double number(std::string_view key, Range range = {}, std::optional<double> fallback = std::nullopt) const;
  int integer(std::string_view key, Range range = {}, std::optional<int> fallback = std::nullopt) const;
  bool flag(std::string_view key, std::optional<bool> fallback = std::nullopt) const;
  std::string text(std::string_view key, std::optional<std::string> fallback = std::nullopt) const;
  // One of the given words.
  std::string choice(std::string_view key, std::initializer_list<std::string_view> words,
                     std::optional<std::string> fallback = std::nullopt) const;
  // Exactly `count` numbers; count 0: any number of them, at least one.
  std::vector<double> numbers(std::string_view key, std::size_t count, Range range = {},
                              std::optional<std::vector<double>> fallback = std::nullopt) const;
  // A list of texts, empty when the key is missing.
  std::vector<std::string> texts(std::string_view key) const;
  // "2026-06-21T03:00:00Z" as a TOML date-time with offset.
  Utc utc(std::string_view key) const;
  std::optional<Utc> optional_utc(std::string_view key) const;
  // A file named relative to the folder of the TOML file; it must exist.
  std::filesystem::path file(std::string_view key) const;
  std::optional<std::filesystem::path> optional_file(std::string_view key) const;

  ConfigTable table(std::string_view key) const;  // required; an empty table and a problem when it is missing
  std::optional<ConfigTable> optional_table(std::string_view key) const;
  std::vector<ConfigTable> tables(std::string_view key) const;  // [[key]]; empty when there is none

  // For showing a table whose contents are unknown: its keys in alphabetical order, and the number or text of a key if
  // it is one. None of these adds a problem.
  std::vector<std::string> keys() const;
  std::optional<double> if_number(std::string_view key) const;
  std::optional<std::string> if_text(std::string_view key) const;

  // Marks a key, and everything below it, as read elsewhere.
  void ignore(std::string_view key) const;

  // For the root, before its tables are read: adds to [TABLE] each key that only the other file's [TABLE] has. A key is
  // added or left out as a whole; tables within [TABLE] are not merged. Of keys that are alternatives to each other
  // (`rivals`), none is added when one is already here. Problems with an added key then name the file it came from, and
  // file names in it are relative to that file's folder.
  struct Adopted {
    std::vector<std::string> gained;     // full keys
    std::vector<std::string> overruled;  // left out, because this file has the key (equal or not) or a rival
  };
  using Rivals = std::vector<std::set<std::string, std::less<>>>;
  Adopted adopt(const ConfigTable& other, std::string_view table, const Rivals& rivals = {}) const;
  // For the root: from now on missing keys are no problem, because they would have come from a file already reported as
  // unusable.
  void excuse_missing() const;

  // "fixture.toml: sky.lens.focal_px = -3: expected a number > 0"
  void problem(std::string_view key, std::string_view expected) const;
  const std::filesystem::path& path() const;
  std::filesystem::path folder() const;

  // Where the copy of a file lies below a folder of copies.
  static std::filesystem::path place_of_copy(const std::filesystem::path& path, const std::filesystem::path& copies);

  // The keys read so far, in full ("sky.lens.focal_px"); for file names, also the path that was tried.
  std::set<std::string> keys_asked() const;
  std::map<std::string, std::filesystem::path> files_asked() const;
  // The given tables and lists of tables of the root as TOML text. `changes` replaces the values of keys in the tables,
  // by full key, with texts; nullopt drops the key and everything below it.
  std::string copy_of(std::initializer_list<std::string_view> tables,
                      const std::map<std::string, std::optional<std::string>>& changes) const;

  // For the root, after everything was read: adds a problem for each key that was never read (a typing error), then
  // fails if there are problems.
  Result<> finish() const;

 private:
  struct File;
  struct Node;
  ConfigTable(std::shared_ptr<File> file, std::shared_ptr<const Node> node)
      : file_(std::move(file)), node_(std::move(node)) {}
  std::string full_key(std::string_view key) const;
  const std::filesystem::path& origin_of(const std::string& full_key) const;

  std::shared_ptr<File> file_;
  std::shared_ptr<const Node> node_;
};

}  // namespace kasumi
