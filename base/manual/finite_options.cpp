#include "base/manual/finite_options.hpp"

#include <cmath>
#include <cstdlib>
#include <set>
#include <string>

#include <CLI/CLI.hpp>

namespace kasumi {
namespace {

// By the type that --help names. Every other type counts as numbers, so that a new kind of option is checked unless it
// is listed here as text.
bool takes_text(const CLI::Option& option) {
  static const std::set<std::string> kTexts{"", "TEXT", "FILE", "FILE.csv", "MODEL"};
  const auto name = option.get_type_name();
  return kTexts.contains(name.substr(0, name.find(':')));
}

// What is wrong with it; empty: nothing, or it is no number at all, which the conversion reports.
std::string problem_of(const std::string& text) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != '\0' || std::isfinite(value)) return {};
  return text + " is no finite number";
}

}  // namespace

void refuse_infinite_numbers(CLI::App& app) {
  for (CLI::Option* option : app.get_options())
    if (!takes_text(*option)) option->check(problem_of);
  for (CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) refuse_infinite_numbers(*command);
}

}  // namespace kasumi
