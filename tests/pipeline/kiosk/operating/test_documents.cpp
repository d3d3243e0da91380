// Commands in the documents must be accepted by the program's own parser. What else they name is held by tests/house.
#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <CLI/CLI.hpp>

#include "pipeline/command_line.hpp"
#include "tests/house/document_code.hpp"

namespace kasumi {
namespace {

// The words behind `kasumi` in "sudo build/kasumi calibrate sky RECORDING"; empty for other programs.
std::vector<std::string> words_for_kasumi(const std::string& line) {
  static const std::regex kCommand(R"((?:ssh \S+ )?(?:sudo )?(?:-u \w+ )?(?:build/)?kasumi( [a-z-].*))");
  std::smatch command;
  if (!std::regex_match(line, command, kCommand)) return {};
  return house::words_of_command(command[1]);
}

bool is_placeholder(const std::string& word) {
  static const std::regex kCapitals(R"([A-Z][A-Z_]+(\.[a-z]+)?(\.\.\.)?)");
  return std::regex_match(word, kCapitals);
}

// Why the parser refuses these words; empty: it does not. A command named in a sentence may leave out what it requires, and the
// values of options.
std::string parse_refusal(std::vector<std::string> words, bool whole) {
  Action action;
  const auto app = command_line(action);
  app->set_version_flag("--version", "");  // main.cpp knows it
  std::ranges::reverse(words);             // as CLI11 takes them
  try {
    app->parse(words);
  } catch (const CLI::Success&) {
    return {};
  } catch (const CLI::RequiredError& error) {
    if (const auto unknown = app->remaining(true); !unknown.empty())
      return fmt::format("unknown: {}", fmt::join(unknown, " "));
    return whole ? error.what() : "";
  } catch (const CLI::ArgumentMismatch& error) {
    return whole ? error.what() : "";
  } catch (const CLI::ParseError& error) {
    const std::string said = error.what();
    return said.find("File does not exist") == std::string::npos ? said : "";
  }
  return {};
}

std::string parse_refusal(const std::string& line, bool whole) {
  auto words = words_for_kasumi(line);
  if (words.empty()) return {};
  auto refused = parse_refusal(words, whole);
  if (refused.empty()) return refused;
  // Words in capitals stand for any: a text, or a number.
  for (auto& word : words)
    if (is_placeholder(word)) word = "1";
  return parse_refusal(words, whole);
}

// "PAGE:12: kasumi fly: ..." for each command that the parser refuses.
std::vector<std::string> command_refusals_in(const std::string& name, const std::string& document, int& commands) {
  std::vector<std::string> found;
  for (const auto& code : house::code_in(document))
    for (const auto& line : house::command_lines_in(code)) {
      if (words_for_kasumi(line).empty()) continue;
      ++commands;
      if (const auto refused = parse_refusal(line, code.block); !refused.empty())
        found.push_back(fmt::format("{}:{}: {}: {}", name, code.line, line, refused));
    }
  return found;
}

TEST(Documents, CommandsAreParsedByTheProgram) {
  int commands = 0;
  for (const auto& [name, text] : house::texts_ending_in(house::repository_files(), {".md"}))
    EXPECT_THAT(command_refusals_in(name, text, commands), testing::IsEmpty());
  EXPECT_GT(commands, 200) << "the documents were not read";
}

TEST(Documents, AnOffendingCommandWouldBeFound) {
  const auto count = [](const std::string& text) {
    int commands = 0;
    return command_refusals_in("a.md", text, commands).size();
  };
  for (const std::string good :
       {"`kasumi replay`", "`kasumi replay FIXTURE --out DIR`", "    sudo build/kasumi doctor [--json] && reboot\n",
        "    ssh kiosk sudo kasumi snapshot --out - > now.png\n", "`sudo systemctl restart kasumi`", "`kasumi COMMAND`",
        "    kasumi sky --turbidity 6 --sun-zenith-deg DEGREES --sun-azimuth-deg 10 \\\n      --out sky.png  # "
        "words\n"})
    EXPECT_EQ(count(good), 0u) << good;
  for (const std::string bad :
       {"`kasumi fly`", "`kasumi replay --colour`", "    kasumi replay\n", "    build/kasumi calibrate moon x\n",
        "    kasumi sky --turbidity six --out sky.png\n", "    ls | sudo kasumi doctor here\n"})
    EXPECT_EQ(count(bad), 1u) << bad;
}

// The names of all commands, those of steps with their command's before them.
void list_commands(const CLI::App& app, const std::string& before, std::set<std::string>& found) {
  for (const auto* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    const auto name = before + command->get_name();
    if (command->get_subcommands([](const CLI::App*) { return true; }).empty()) found.insert(name);
    list_commands(*command, name + " ", found);
  }
}

TEST(Documents, ShowAnExampleOfEveryCommandOnThePageOfCommands) {
  std::set<std::string> commands;
  Action action;
  list_commands(*command_line(action), "", commands);
  EXPECT_GE(commands.size(), 20u);
  std::set<std::string> missing = commands;
  const auto page = read_text_file(source_folder() / "docs/commands.md").value();
  for (const auto& code : house::code_in(page))
    for (const auto& line : house::command_lines_in(code)) {
      const auto words = words_for_kasumi(line);
      if (!words.empty()) missing.erase(words[0]);
      if (words.size() > 1) missing.erase(words[0] + " " + words[1]);
    }
  EXPECT_THAT(missing, testing::IsEmpty());
}

}  // namespace
}  // namespace kasumi
