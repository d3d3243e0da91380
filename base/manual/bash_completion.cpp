#include <map>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "base/manual/manual.hpp"

namespace kasumi {

namespace {

// What may follow a command, by its whole name ("kasumi content pack").
struct Completions {
  std::vector<std::string> paths;                                // of all commands below the program
  std::map<std::string, std::vector<std::string>> words, files;  // files: commands that take them
  std::map<std::string, std::string> choices;  // by "COMMAND --option": its words, "" : a file or anything
};

// "TEXT:{sky,scene}" -> "sky scene"
std::string words_of(const CLI::Option& option) {
  const auto type = option.get_type_name();
  const auto from = type.find('{'), to = type.rfind('}');
  if (from == std::string::npos || to == std::string::npos || to < from) return {};
  auto words = type.substr(from + 1, to - from - 1);
  for (auto& c : words)
    if (c == ',') c = ' ';
  return words;
}

void gather(const CLI::App& app, const std::string& path, Completions& found) {
  auto& words = found.words[path];
  for (const auto* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    words.push_back(command->get_name());
    const auto below = path + " " + command->get_name();
    found.paths.push_back(below);
    gather(*command, below, found);
  }
  for (const auto* option : app.get_options()) {
    if (option->get_group().empty()) continue;
    if (option->get_positional()) found.files[path].push_back(option->get_name());
    for (const auto& name : option->get_lnames()) {
      words.push_back("--" + name);
      if (option->get_items_expected_max() > 0) found.choices[path + " --" + name] = words_of(*option);
    }
  }
}

}  // namespace

std::string bash_completion(const CLI::App& app) {
  const auto name = app.get_name();
  Completions found;
  gather(app, name, found);
  std::string function = "_" + name;
  for (auto& c : function)
    if (c == '-') c = '_';
  std::string text = fmt::format(R"(# bash completion for {0}, made by `{0} --manual bash`
{1}() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} path={0} words= i
  if [[ $word == "=" ]]; then
    word=
  elif [[ $before == "=" ]]; then
    before=${{COMP_WORDS[COMP_CWORD - 2]}}
  fi
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "$path ${{COMP_WORDS[i]}}" in
      "{2}") path+=" ${{COMP_WORDS[i]}}" ;;
    esac
  done
  COMPREPLY=()
  case "$path $before" in
)",
                                 name, function, fmt::join(found.paths, "\" | \""));
  std::string values;
  for (const auto& [option, words] : found.choices) {
    if (words.empty())
      values += (values.empty() ? "" : " | ") + fmt::format("\"{}\"", option);
    else
      text +=
          fmt::format("    \"{}\")\n      mapfile -t COMPREPLY < <(compgen -W \"{}\" -- \"$word\")\n      return ;;\n",
                      option, words);
  }
  if (!values.empty())
    text += fmt::format(
        "    {})\n      compopt -o filenames 2>/dev/null\n      mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
        "      return ;;\n",
        values);
  text += "  esac\n  case \"$path\" in\n";
  for (const auto& [path, words] : found.words)
    text += fmt::format("    \"{}\") words=\"{}\" ;;\n", path, fmt::join(words, " "));
  text += "  esac\n  mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n";
  if (!found.files.empty()) {
    std::vector<std::string> takers;
    for (const auto& [path, names] : found.files) takers.push_back(path);
    text += fmt::format(
        "  if [[ $word != -* ]]; then\n    case \"$path\" in\n      \"{}\")\n        compopt -o filenames 2>/dev/null\n"
        "        mapfile -t COMPREPLY < <(compgen -f -- \"$word\") ;;\n    esac\n  fi\n",
        fmt::join(takers, "\" | \""));
  }
  return text + fmt::format("}}\ncomplete -F {} {}\n", function, name);
}

}  // namespace kasumi
