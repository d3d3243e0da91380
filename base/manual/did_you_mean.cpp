#include <CLI/CLI.hpp>

#include "base/manual/manual.hpp"
#include "base/words/nearest_word.hpp"

namespace kasumi {

namespace {

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const auto* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

std::vector<std::string> option_names(const CLI::App& command) {
  std::vector<std::string> names{"--help"};
  for (const auto* option : command.get_options())
    for (const auto& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

// "matchd not in {matched,explicit}": CLI11's own words.
std::string meant_value(const std::string& refusal) {
  const auto middle = refusal.find(" not in {"), end = refusal.find('}', middle);
  if (middle == std::string::npos || end == std::string::npos) return {};
  const auto from = refusal.rfind(' ', middle - 1);
  const auto typed = refusal.substr(from == std::string::npos ? 0 : from + 1, middle - from - 1);
  std::vector<std::string> words;
  for (std::size_t at = middle + 9; at < end;) {
    const auto comma = std::min(refusal.find(',', at), end);
    words.push_back(refusal.substr(at, comma - at));
    at = comma + 1;
  }
  const auto nearest = nearest_word(typed, words);
  return nearest.empty() ? "" : "did you mean " + nearest + "?\n";
}

}  // namespace

std::string meant_instead(const CLI::App& app, const std::string& refusal, int argc, char** argv) {
  if (const auto value = meant_value(refusal); !value.empty()) return value;
  const CLI::App* command = &app;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--") break;
    if (word.starts_with("--") && word.size() > 2) {
      const auto name = word.substr(0, word.find('='));
      const auto known = option_names(*command);
      if (std::ranges::find(known, name) != known.end()) continue;
      const auto nearest = nearest_word(name, known);
      return nearest.empty() ? "" : "did you mean " + nearest + "?\n";
    }
    const auto commands = command_names(*command);
    if (word.starts_with('-') || commands.empty()) continue;
    const auto at = std::ranges::find(commands, word);
    if (at != commands.end()) {
      command = command->get_subcommand(*at);
      continue;
    }
    const auto nearest = nearest_word(word, commands);
    return nearest.empty() ? "" : "did you mean " + nearest + "?\n";
  }
  return {};
}

}  // namespace kasumi
