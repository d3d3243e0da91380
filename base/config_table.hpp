// A TOML file read strictly: every getter names file, key, value and what is expected, and all problems are collected
// before anybody gives up.
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

// One table of the file. Copies are cheap and share the list of problems and of keys that were read.
// A getter that finds something wrong adds a problem and returns the fallback (or zero, empty), so that reading can go
// on.
class ConfigTable {
 public:
  // Fails when the file cannot be read or is not TOML (message with line and column).
  static Result<ConfigTable> read_file(const std::filesystem::path& path);
  static Result<ConfigTable> parse(std::string_view text, const std::filesystem::path& name);

  bool has(std::string_view key) const;
  // Required when no fallback is given. Numbers must be finite and inside the range, bounds included.
  double number(std::string_view key, Range range = {}, std::optional<double> fallback = std::nullopt) const;
  int integer(std::string_view key, Range range = {}, std::optional<int> fallback = std::nullopt) const;
  bool flag(std::string_view key, std::optional<bool> fallback = std::nullopt) const;
  std::string text(std::string_view key, std::optional<std::string> fallback = std::nullopt) const;
  // One of a list of words.
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

  // For whoever shows a table without knowing what is in it: its keys in the order of the alphabet, and a number or a
  // text where there is one. Nothing is a problem.
  std::vector<std::string> keys() const;
  std::optional<double> if_number(std::string_view key) const;
  std::optional<std::string> if_text(std::string_view key) const;

  // Says that a key, and all below it, is somebody else's to read.
  void ignore(std::string_view key) const;

  // For the root, before its tables are read: [TABLE] gains the keys that another file's [TABLE] has and it has not,
  // each as a whole. Of keys that are several ways to say one thing (`rivals`), none is gained when one is here. From
  // then on problems with a gained key name its own file, and the files it names are looked for beside that one.
  struct Adopted {
    std::vector<std::string> gained;     // full keys
    std::vector<std::string> overruled;  // the other file has them, and this one says otherwise (or the same)
  };
  using Rivals = std::vector<std::set<std::string, std::less<>>>;
  Adopted adopt(const ConfigTable& other, std::string_view table, const Rivals& rivals = {}) const;
  // For the root: what is missing from now on would have come from a file that cannot be used, which has been told.
  void excuse_missing() const;

  // "fixture.toml: sky.lens.focal_px = -3: expected a number > 0"
  void problem(std::string_view key, std::string_view expected) const;
  const std::filesystem::path& path() const;
  std::filesystem::path folder() const;

  // What was asked for so far, by full key ("sky.lens.focal_px"); of files, where they were looked for.
  std::set<std::string> keys_asked() const;
  std::map<std::string, std::filesystem::path> files_asked() const;
  // These tables, and lists of tables, of the root as TOML text. A change of a table, by full key, is another text for
  // it; nothing: the key and all below it are left out.
  std::string copy_of(std::initializer_list<std::string_view> tables,
                      const std::map<std::string, std::optional<std::string>>& changes) const;

  // For the root, after everything was read: adds a problem for each key nobody asked for (a typing error), then says
  // whether all is well.
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
