// No number that is none gets past the command line: every option of every command that takes numbers is tried.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <CLI/CLI.hpp>

#include "pipeline/command_line.hpp"
#include "tests/pipeline/run_kasumi.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

struct NumericOption {
  std::vector<std::string> command;  // "calibrate", "lens"
  std::string name;                  // "--fov-deg"
  int count = 1;                     // of its values
};

// Options whose help says FLOAT, or in words what numbers they take.
void collect(const CLI::App& app, const std::vector<std::string>& path, std::vector<NumericOption>& all) {
  for (const CLI::Option* option : app.get_options()) {
    const auto type = option->get_type_name();
    const auto is = [&](const char* name) { return type.starts_with(name); };
    if (is("FLOAT") || is("R,G,B") || is("S,S,...") || is("CX,CY,R"))
      all.push_back({path, option->get_name(), std::max(1, option->get_expected_min())});
  }
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    auto longer = path;
    longer.push_back(command->get_name());
    collect(*command, longer, all);
  }
}

// What is said of the option when each of its values is `value`; empty: it was taken.
std::string said_of(const NumericOption& option, const std::string& value) {
  Action action;
  const auto app = command_line(action);
  std::vector<std::string> words = option.command;
  words.push_back(option.name);
  for (int i = 0; i < option.count; ++i) words.push_back(value);
  std::reverse(words.begin(), words.end());
  try {
    app->parse(words);
  } catch (const CLI::ParseError& error) {
    return error.what();
  }
  return "";
}

TEST(NumbersOnTheCommandLine, NanIsRefusedByEveryOptionThatTakesNumbers) {
  Action action;
  std::vector<NumericOption> options;
  collect(*command_line(action), {}, options);
  EXPECT_GE(options.size(), 60u) << "of how many options was this tried?";
  for (const auto& option : options) {
    const auto name = fmt::format("{} {}", fmt::join(option.command, " "), option.name);
    EXPECT_THAT(said_of(option, "nan"), HasSubstr(option.name + ": nan is no finite number")) << name;
  }
}

TEST(NumbersOnTheCommandLine, InEverySpellingThatTheLibraryReads) {
  const NumericOption latitude{{"estimate"}, "--lat", 1}, circle{{"estimate"}, "--circle", 3};
  for (const char* value : {"nan", "NaN", "-nan", "nan(1)", "inf", "-inf", "INFINITY", "1e999"}) {
    EXPECT_THAT(said_of(latitude, value), HasSubstr("--lat")) << value;
    EXPECT_THAT(said_of(circle, value), HasSubstr("--circle")) << value;
  }
  EXPECT_THAT(said_of(latitude, "46.94"), testing::Not(HasSubstr("--lat")));
}

// As in a shell, and where an option's text is read by a reader of its own.
TEST(NumbersOnTheCommandLine, ExitCodeTwoTellsSo) {
  const auto picture = (source_folder() / "fixtures/demo/scene/frame-000000.jpg").string();
  for (const auto& arguments :
       {std::string("estimate x.png --lat nan --lon 8 --utc 2018-01-29T11:09:20Z"),
        fmt::format("retarget {} --distance-m 100 --source-turbidity 2 --turbidity nan --out o.png", picture),
        fmt::format("haze {} --depth d.pfm --turbidity 2:nan:1 --out o.png", picture)}) {
    const auto outcome = run_kasumi(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments << "\n" << outcome.out << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("nan")) << arguments;
  }
}

}  // namespace
}  // namespace kasumi
