#include <algorithm>
#include <cctype>
#include <cstdio>
#include <iostream>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "base/manual/manual.hpp"
#include "base/manual/roff.hpp"

namespace kasumi {

namespace {

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string sentence(std::string text) {
  if (!text.empty() && text.back() != '.') text += '.';
  return text;
}

// CLI11 writes what is allowed behind the kind: "FLOAT:FLOAT in [0 - 180]", "TEXT:{sky,scene}".
struct Taken {
  std::string kind, allowed;
};
Taken taken_by(const CLI::Option& option) {
  const auto type = option.get_type_name();
  const auto colon = type.find(':');
  if (colon == std::string::npos) return {type, {}};
  Taken taken{type.substr(0, colon), {}};
  const auto rule = type.substr(colon + 1);
  if (rule.starts_with('{') && rule.ends_with('}')) {
    for (const char c : rule.substr(1, rule.size() - 2)) taken.allowed += c == ',' ? std::string(", ") : std::string{c};
  } else if (const auto range = rule.find(" in ["); range != std::string::npos && rule.ends_with(']')) {
    taken.allowed = rule.substr(range + 5, rule.size() - range - 6);
    if (const auto dash = taken.allowed.find(" - "); dash != std::string::npos) taken.allowed.replace(dash, 3, " to ");
  }
  return taken;
}

bool takes_value(const CLI::Option& option) {
  return option.get_items_expected_max() > 0;
}

std::string option_text(const CLI::Option& option) {
  std::string names;
  const auto add = [&](const std::string& name) { names += (names.empty() ? "\\fB" : ", \\fB") + roff(name) + "\\fR"; };
  if (option.get_positional()) names = "\\fI" + roff(option.get_name()) + "\\fR";
  for (const auto& name : option.get_snames()) add("-" + name);
  for (const auto& name : option.get_lnames()) add("--" + name);
  const auto taken = taken_by(option);
  const bool many = option.get_items_expected_max() > 1;
  if (!option.get_positional() && takes_value(option)) names += " \\fI" + roff(taken.kind) + "\\fR";
  if (many) names += " ...";
  auto text = sentence(option.get_description());
  if (!taken.allowed.empty())
    text += " " + sentence((taken.allowed.find(", ") != std::string::npos ? "One of " : "") + taken.allowed);
  if (option.get_required()) text += " Required.";
  if (const auto usual = option.get_default_str(); !usual.empty()) text += " Default: " + usual + ".";
  return fmt::format(".TP\n{}\n{}\n", names, roff(text));
}

void describe(const CLI::App& app, const std::string& path, std::string& page) {
  auto synopsis = ".B " + roff(path) + "\n";
  std::string options;
  for (const auto* option : app.get_options()) {
    if (option->get_group().empty() || option->get_name() == "--help") continue;
    options += option_text(*option);
    if (option->get_positional())
      synopsis += fmt::format(".RI {0} {1} {2}\n", option->get_required() ? "\"\"" : "[", roff(option->get_name()),
                              option->get_required() ? "\"\"" : "]");
  }
  const auto commands = app.get_subcommands([](const CLI::App*) { return true; });
  page += fmt::format(".SS {}\n{}", roff(path), roff(sentence(app.get_description())) + "\n");
  if (commands.empty()) page += ".PP\n" + synopsis + (options.empty() ? "" : ".RI [ options ]\n");
  page += options;
  for (const auto* command : commands) describe(*command, path + " " + command->get_name(), page);
}

}  // namespace

std::string manual_page(const CLI::App& app, std::string_view version) {
  const auto name = app.get_name();
  auto what = app.get_description();
  if (what.starts_with("Kasumi: ")) what = what.substr(8);  // whatis(1) shows the name before it
  std::string page = fmt::format(
      ".TH {} 1 \"\" \"{} {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n.B {}\n.I command\n.RI [ options "
      "]\n"
      ".SH DESCRIPTION\n{}\n.PP\nEach command prints its options with\n.BR \\-\\-help .\n.SH COMMANDS\n",
      upper(name), name, version, roff(name), roff(what), roff(name), roff(sentence(app.get_description())));
  for (const auto* command : app.get_subcommands([](const CLI::App*) { return true; }))
    describe(*command, name + " " + command->get_name(), page);
  if (const auto footer = app.get_footer(); !footer.empty()) page += ".SH NOTES\n" + roff(footer) + "\n";
  page +=
      ".SH SEE ALSO\n.BR kasumi (1),\n.BR kasumi\\-report (1),\n.BR kasumi.toml (5)\n.PP\n"
      "/usr/share/doc/kasumi/docs/README.md lists all documents.\n";
  return page;
}

bool print_manual(const CLI::App& app, std::string_view version, int argc, char** argv) {
  if (argc != 3 || std::string_view(argv[1]) != "--manual") return false;
  const std::string_view kind = argv[2];
  std::string text;
  if (kind == "page") text = manual_page(app, version);
  if (kind == "bash") text = bash_completion(app);
  if (kind == "keys") {
    std::string example;
    for (std::string line; std::getline(std::cin, line);) example += line + "\n";
    text = key_page(example, "kasumi.toml", version);
  }
  std::fputs(text.c_str(), stdout);
  return !text.empty();
}

}  // namespace kasumi
