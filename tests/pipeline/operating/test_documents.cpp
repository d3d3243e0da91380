// Commands in the documents must be accepted by the program.
#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/pipeline/run_kasumi.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

// Commands that a document tells readers to type: the lines of its indented blocks, joined where they end in a
// backslash, and `kasumi ...` in its sentences.
std::vector<std::string> commands_in(std::string document) {
  static const std::regex kContinued(R"(\\\n *)"), kBreak(R"(\n *)"), kTyped(R"(`((?:build/)?kasumi [a-z][^`]*)`)");
  document = std::regex_replace(document, kContinued, "");
  std::vector<std::string> commands;
  std::istringstream stream(document);
  for (std::string line; std::getline(stream, line);)
    if (line.starts_with("    ")) commands.push_back(line.substr(4, line.find(" # ") - 4));
  document = std::regex_replace(document, kBreak, " ");
  for (std::sregex_iterator typed(document.begin(), document.end(), kTyped), last; typed != last; ++typed)
    commands.push_back((*typed)[1]);
  return commands;
}

// "calibrate sky" of "sudo build/kasumi calibrate sky RECORDING --out FILE"; empty for other programs.
std::string command_of(const std::string& line) {
  static const std::regex kCommand(R"((?:sudo )?(?:-u \w+ )?(?:build/)?kasumi ([a-z]+)( [a-z]+)?(?: .*)?)");
  std::smatch parts;
  if (!std::regex_match(line, parts, kCommand)) return "";
  const bool has_commands = parts[1] == "calibrate" || parts[1] == "content";
  return has_commands ? parts[1].str() + parts[2].str() : parts[1].str();
}

// Output of `kasumi COMMAND --help`, run once each.
const std::string& help_of(const std::string& command) {
  static std::map<std::string, std::string> known;
  const auto [at, fresh] = known.try_emplace(command);
  if (fresh) {
    const auto outcome = run_kasumi(command + " --help");
    at->second = outcome.code == 0 ? outcome.out : "";
  }
  return at->second;
}

TEST(Documents, MentionOnlyOptionsOfTheProgram) {
  const std::filesystem::path root = source_folder();
  std::vector<std::filesystem::path> documents{root / "README.md", root / "CHANGELOG.md", root / "CONTRIBUTING.md",
                                               root / "fixtures/README.md"};
  for (const auto& entry : std::filesystem::directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") documents.push_back(entry.path());
  int commands = 0;
  for (const auto& document : documents) {
    for (const auto& line : commands_in(read_text_file(document).value())) {
      const auto command = command_of(line);
      if (command.empty()) continue;
      ++commands;
      const auto& help = help_of(command);
      EXPECT_FALSE(help.empty()) << document << ": no such command: " << line;
      for (const auto& word : words_of(line)) {
        static const std::regex kOption(R"(\[?(--[a-z][a-z0-9-]*).*)");
        std::smatch option;
        if (!std::regex_match(word, option, kOption)) continue;
        EXPECT_TRUE(std::regex_search(help, std::regex(option[1].str() + "[ :,\\n]")))
            << document << ": " << option[1] << " is no option of `kasumi " << command << "`: " << line;
      }
    }
  }
  EXPECT_GT(commands, 100) << "the documents were not read";
}

// The names of the subcommands that `kasumi COMMAND --help` lists.
std::vector<std::string> subcommands_of(const std::string& command) {
  static const std::regex kName(R"(^  ([a-z]+) .*)");
  const auto& help = help_of(command);
  std::istringstream stream(help.substr(std::min(help.find("Subcommands:"), help.size())));
  std::vector<std::string> names;
  std::smatch name;
  for (std::string line; std::getline(stream, line);)
    if (std::regex_match(line, name, kName)) names.push_back(name[1]);
  return names;
}

TEST(Documents, ShowAnExampleOfEveryCommandOnThePageOfCommands) {
  std::set<std::string> shown{"calibrate"};  // by its steps
  for (const auto& line : commands_in(read_text_file(source_folder() / "docs/commands.md").value()))
    shown.insert(command_of(line));
  const auto commands = subcommands_of("");
  EXPECT_GE(commands.size(), 10u) << "the help was not read";
  for (const auto& command : commands) EXPECT_TRUE(shown.contains(command)) << command;
  const auto steps = subcommands_of("calibrate");
  EXPECT_GE(steps.size(), 10u) << "the help was not read";
  for (const auto& step : steps) EXPECT_TRUE(shown.contains("calibrate " + step)) << "calibrate " << step;
}

}  // namespace
}  // namespace kasumi
