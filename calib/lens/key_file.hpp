// Files of keys and numbers as calibration programs write them: OpenCV's YAML, XML and JSON, and plain YAML.
#pragma once

#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "base/result.hpp"

namespace kasumi {

class KeyFile {
 public:
  // Errors (bad_input, without the file's name): none of these, damaged.
  static Result<KeyFile> parse(const std::string& text);

  // Full keys, "cam0.intrinsics"; a matrix's numbers are those of its "data". The first of `keys` that is there, below
  // `prefix`; empty: none, or not finite numbers.
  std::vector<double> numbers(std::initializer_list<const char*> keys, const std::string& prefix = {}) const;
  std::optional<double> number(std::initializer_list<const char*> keys, const std::string& prefix = {}) const;
  std::optional<std::string> text(std::initializer_list<const char*> keys, const std::string& prefix = {}) const;
  bool has(const std::string& key) const;
  // Keys with numbers that were never read, except those below the names in `harmless`.
  // Keys asked for numbers among which something else stands, such as nan.
  std::vector<std::string> broken() const;
  std::vector<std::string> unread(const std::set<std::string, std::less<>>& harmless) const;

 private:
  struct Value {
    std::vector<double> numbers;
    std::string text;
    mutable bool asked = false;
    mutable bool asked_for_numbers = false;
  };
  const Value* find(std::initializer_list<const char*> keys, const std::string& prefix) const;
  static Result<KeyFile> parse_xml(const std::string& text);
  static Result<KeyFile> parse_json(const std::string& text);
  static Result<KeyFile> parse_yaml(const std::string& text);
  void add(const std::string& key, const std::string& token);

  std::map<std::string, Value, std::less<>> values_;
};

}  // namespace kasumi
