// What the documents tell people to type must be what the program takes.
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/pipeline/program.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

// Of `kasumi COMMAND --help`, each asked for once.
const std::string& help_of(const std::string& command) {
  static std::map<std::string, std::string> known;
  const auto [at, fresh] = known.try_emplace(command);
  if (fresh) {
    const auto outcome = run_kasumi(command + " --help");
    at->second = outcome.code == 0 ? outcome.out : "";
  }
  return at->second;
}

TEST(Documents, TellNoOptionThatTheProgramDoesNotHave) {
  const std::filesystem::path root = source_folder();
  std::vector<std::filesystem::path> documents{root / "README.md"};
  for (const auto& entry : std::filesystem::directory_iterator(root / "docs"))
    if (entry.path().extension() == ".md") documents.push_back(entry.path());
  int commands = 0;
  for (const auto& document : documents) {
    std::ifstream file(document);
    for (std::string line; std::getline(file, line);) {
      // A block of commands is indented by four.
      static const std::regex kCommand(R"(^    (?:sudo )?(?:-u \w+ )?(?:build/)?kasumi ([a-z]+)( [a-z]+)?(?: (.*))?$)");
      std::smatch parts;
      if (!std::regex_match(line, parts, kCommand)) continue;
      std::string command = parts[1];
      if (command == "calibrate") command += parts[2];
      ++commands;
      const auto& help = help_of(command);
      EXPECT_FALSE(help.empty()) << document << ": no such command: " << line;
      for (const auto& word : words_of(line.substr(0, line.find(" # ")))) {
        static const std::regex kOption(R"(\[?(--[a-z][a-z0-9-]*).*)");
        std::smatch option;
        if (!std::regex_match(word, option, kOption)) continue;
        EXPECT_TRUE(std::regex_search(help, std::regex(option[1].str() + "[ :,\\n]")))
            << document << ": " << option[1] << " is no option of `kasumi " << command << "`: " << line;
      }
    }
  }
  EXPECT_GT(commands, 20) << "the documents were not read";
}

}  // namespace
}  // namespace kasumi
