#include "calib/lens/key_file.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/finite_number.hpp"
#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"

namespace kasumi {
namespace {

constexpr int kDeepest = 12;
constexpr std::size_t kMostNumbers = 200'000;

std::string trimmed(const std::string& text) {
  const auto from = text.find_first_not_of(" \t\r\n");
  if (from == std::string::npos) return {};
  return text.substr(from, text.find_last_not_of(" \t\r\n") - from + 1);
}

std::string without_quotes(std::string text) {
  if (text.size() >= 2 && (text.front() == '"' || text.front() == '\'') && text.back() == text.front())
    return text.substr(1, text.size() - 2);
  return text;
}

int open_brackets(const std::string& text) {
  return static_cast<int>(std::ranges::count(text, '[') - std::ranges::count(text, ']'));
}

}  // namespace

void KeyFile::add(const std::string& key, const std::string& token) {
  auto& value = values_[key];
  if (const auto number = finite_number(token))
    value.numbers.push_back(*number);
  else
    value.text += (value.text.empty() ? "" : " ") + without_quotes(token);
}

// What of YAML such files use: keys below keys by indentation, lists in brackets or of lines with a dash.
Result<KeyFile> KeyFile::parse_yaml(const std::string& text) {
  KeyFile file;
  struct Level {
    std::size_t indentation;
    std::string key;
  };
  std::vector<Level> levels;
  std::istringstream lines(text);
  std::size_t numbers = 0;
  const auto add_all = [&](const std::string& key, std::string values) {
    for (char& c : values)
      if (c == '[' || c == ']' || c == ',') c = ' ';
    std::istringstream tokens(values);
    for (std::string token; tokens >> token && numbers < kMostNumbers; ++numbers)
      if (token != "-") file.add(key, token);  // of a list within a list
  };
  for (std::string line; std::getline(lines, line);) {
    std::ranges::replace(line, '\t', ' ');
    if (const auto comment = line.find('#'); comment != std::string::npos && (comment == 0 || line[comment - 1] == ' '))
      line.resize(comment);
    const auto content = trimmed(line);
    if (content.empty() || content == "---" || content == "..." || content.starts_with("%")) continue;
    const auto indentation = line.find_first_not_of(' ');
    const bool item = content.starts_with("- ");
    while (!levels.empty() &&
           (levels.back().indentation > indentation || (levels.back().indentation == indentation && !item)))
      levels.pop_back();
    const auto colon = content.find(": ") != std::string::npos ? content.find(": ")
                       : content.ends_with(':')                ? content.size() - 1
                                                               : std::string::npos;
    if (item || colon == std::string::npos) {
      if (levels.empty()) return fail(FaultKind::bad_input, "\"{}\" is no key with a value", content.substr(0, 60));
      auto values = item ? content.substr(2) : content;
      for (std::string more; open_brackets(values) > 0 && std::getline(lines, more);) values += " " + more;
      add_all(levels.back().key, values);
      continue;
    }
    const auto name = without_quotes(trimmed(content.substr(0, colon)));
    auto value = trimmed(content.substr(colon + 1));
    const auto key = levels.empty() ? name : levels.back().key + "." + name;
    if (value.empty() || value.starts_with("!!")) {
      if (levels.size() >= kDeepest)
        return fail(FaultKind::bad_input, "keys below keys of more than {} levels", kDeepest);
      levels.push_back({indentation, key});
      continue;
    }
    for (std::string more; open_brackets(value) > 0 && std::getline(lines, more);) value += " " + trimmed(more);
    if (value.starts_with('{') && value.ends_with('}')) {  // keys below it in one line
      value = value.substr(1, value.size() - 2) + ",";
      for (std::size_t from = 0, at = 0; at < value.size(); ++at) {
        if (value[at] != ',' || open_brackets(value.substr(from, at - from)) > 0) continue;
        const auto part = value.substr(from, at - from);
        if (const auto of = part.find(':'); of != std::string::npos)
          add_all(key + "." + without_quotes(trimmed(part.substr(0, of))), part.substr(of + 1));
        from = at + 1;
      }
    } else if (value.starts_with('['))
      add_all(key, value);
    else
      file.add(key, value);
  }
  if (file.values_.empty()) return fail(FaultKind::bad_input, "no keys with values");
  return file;
}

// Elements within elements; OpenCV's own parser reads behind the end of what is cut off.
Result<KeyFile> KeyFile::parse_xml(const std::string& text) {
  KeyFile file;
  std::vector<std::string> open;  // full keys; the outermost element is the file itself
  std::size_t numbers = 0;
  for (std::size_t at = 0; at < text.size();) {
    const auto tag = std::min(text.find('<', at), text.size());
    if (!open.empty()) {
      std::istringstream words(text.substr(at, tag - at));
      for (std::string word; words >> word && numbers < kMostNumbers; ++numbers) file.add(open.back(), word);
    }
    if (tag == text.size()) break;
    const auto end = text.find('>', tag);
    if (end == std::string::npos) return fail(FaultKind::bad_input, "the XML ends within an element");
    auto name = text.substr(tag + 1, end - tag - 1);
    at = end + 1;
    if (name.starts_with('?') || name.starts_with('!') || name.ends_with('/')) continue;
    if (name.starts_with('/')) {
      if (open.empty()) return fail(FaultKind::bad_input, "an element ends that did not begin: {}", name.substr(0, 60));
      open.pop_back();
      continue;
    }
    name = name.substr(0, name.find_first_of(" \t\r\n"));
    if (open.size() >= kDeepest)
      return fail(FaultKind::bad_input, "elements within elements of more than {} levels", kDeepest);
    open.push_back(open.size() < 2 ? (open.empty() ? "" : name) : open.back() + "." + name);
  }
  file.values_.erase("");
  if (!open.empty()) return fail(FaultKind::bad_input, "the XML ends within {}", open.back().substr(0, 60));
  if (file.values_.empty()) return fail(FaultKind::bad_input, "no keys with values");
  return file;
}

Result<KeyFile> KeyFile::parse_json(const std::string& text) {
  const auto json = kasumi::parse_json(modest_json(text));
  if (!json.is_object()) return fail(FaultKind::bad_input, "not JSON");
  KeyFile file;
  std::size_t numbers = 0;
  const auto flatten = [&](const auto& self, const nlohmann::json& node, const std::string& key) -> void {
    if (numbers > kMostNumbers) return;
    if (node.is_object()) {
      for (const auto& [name, child] : node.items()) self(self, child, key.empty() ? name : key + "." + name);
    } else if (node.is_array()) {
      for (const auto& child : node) self(self, child, key);
    } else if (node.is_number()) {
      file.values_[key].numbers.push_back(node.get<double>());
      ++numbers;
    } else if (node.is_string()) {
      file.values_[key].text = node.get<std::string>();
    }
  };
  flatten(flatten, json, "");
  if (file.values_.empty()) return fail(FaultKind::bad_input, "no keys with values");
  return file;
}

Result<KeyFile> KeyFile::parse(const std::string& whole) {
  constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
  const std::string text = whole.starts_with(kByteOrderMark) ? whole.substr(kByteOrderMark.size()) : whole;
  const auto start = trimmed(text.substr(0, 4096));
  if (start.starts_with('<')) return parse_xml(text);
  return start.starts_with('{') ? parse_json(text) : parse_yaml(text);
}

const KeyFile::Value* KeyFile::find(std::initializer_list<const char*> keys, const std::string& prefix) const {
  for (const char* key : keys)
    for (const auto& name : {prefix + key, prefix + key + ".data"})
      if (const auto found = values_.find(name); found != values_.end()) {
        found->second.asked = true;
        return &found->second;
      }
  return nullptr;
}

std::vector<double> KeyFile::numbers(std::initializer_list<const char*> keys, const std::string& prefix) const {
  const auto* value = find(keys, prefix);
  if (value) value->asked_for_numbers = true;
  if (!value || !std::ranges::all_of(value->numbers, [](double x) { return std::isfinite(x); })) return {};
  return value->numbers;
}

std::optional<double> KeyFile::number(std::initializer_list<const char*> keys, const std::string& prefix) const {
  const auto all = numbers(keys, prefix);
  return all.size() == 1 ? std::optional(all.front()) : std::nullopt;
}

std::optional<std::string> KeyFile::text(std::initializer_list<const char*> keys, const std::string& prefix) const {
  const auto* value = find(keys, prefix);
  return value && !value->text.empty() ? std::optional(value->text) : std::nullopt;
}

std::vector<std::string> KeyFile::broken() const {
  std::vector<std::string> keys;
  for (const auto& [key, value] : values_)
    if (value.asked_for_numbers && !value.numbers.empty() && !value.text.empty())
      keys.push_back(fmt::format("{}: \"{}\" among its numbers", key, value.text.substr(0, 60)));
  return keys;
}

bool KeyFile::has(const std::string& key) const {
  return values_.contains(key) || values_.contains(key + ".data");
}

std::vector<std::string> KeyFile::unread(const std::set<std::string, std::less<>>& harmless) const {
  std::vector<std::string> left;
  for (const auto& [key, value] : values_) {
    const auto last = key.substr(key.rfind('.') + 1);
    const bool shape = last == "rows" || last == "cols" || last == "dt";
    if (value.asked || value.numbers.empty() || shape) continue;
    bool known = harmless.contains(last) || key.find("std_dev") != std::string::npos;
    for (std::size_t dot = key.find('.'), from = 0;; from = dot + 1, dot = key.find('.', from)) {
      known = known || harmless.contains(key.substr(from, dot == std::string::npos ? dot : dot - from));
      if (dot == std::string::npos) break;
    }
    if (!known) left.push_back(key);
  }
  return left;
}

}  // namespace kasumi
