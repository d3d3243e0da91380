// The commands in the documents name what is there: words of ./bootstrap, targets, presets, programs and their options,
// units and files. tests/pipeline/kiosk/operating/test_documents.cpp parses those of `kasumi` itself.
#include <algorithm>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/house/document_code.hpp"

namespace kasumi::house {
namespace {

void for_each_match(const std::string& text, const std::regex& pattern,
                    const std::function<void(const std::smatch&)>& use) {
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), last; match != last; ++match) use(*match);
}

struct Known {
  std::set<std::string> files;                  // and folders, by name from the root
  std::set<std::string> tasks;                  // of ./bootstrap
  std::set<std::string> targets;                // that CMake makes
  std::set<std::string> presets;                // of CMakePresets.json
  std::set<std::string> suites;                 // of GoogleTest
  std::set<std::string> units;                  // of systemd, with and without their endings
  std::map<std::string, std::string> programs;  // our executables, and the text of their sources
};

// `texts`: bootstrap, CMakePresets.json, every CMakeLists.txt and the sources.
Known known_in(const std::set<std::string>& files, const Texts& texts) {
  Known known;
  for (const auto& name : files) {
    known.files.insert(name);
    for (auto slash = name.rfind('/'); slash != std::string::npos; slash = name.rfind('/', slash - 1)) {
      known.files.insert(name.substr(0, slash));
      if (slash == 0) break;
    }
    static const std::regex kUnit(R"(systemd/(?:.*/)?([^/]+)\.(service|path|target|timer|mount|socket))");
    std::smatch unit;
    if (!std::regex_match(name, unit, kUnit)) continue;
    known.units.insert(unit[1]);
    known.units.insert(unit[1].str() + "." + unit[2].str());
  }
  static const std::regex kTask(R"(\n  ([a-z0-9]+)\)\n)"), kPreset(R"re("name": "([a-z0-9]+)")re"),
      kTarget(R"((?:add_executable|add_custom_target|add_library|kasumi_test|kasumi_fuzzer)\(([a-z0-9_-]+))"),
      kProgram(R"(add_executable\((kasumi-[a-z-]+)([^)]*))"), kWord(R"([^\s]+)"), kSuite(R"(\bTEST(?:_F|_P)?\((\w+),)");
  for (const auto& [name, text] : texts) {
    if (name == "bootstrap") for_each_match(text, kTask, [&](const auto& task) { known.tasks.insert(task[1]); });
    if (name == "CMakePresets.json")
      for_each_match(text, kPreset, [&](const auto& preset) { known.presets.insert(preset[1]); });
    if (name.ends_with(".cpp")) for_each_match(text, kSuite, [&](const auto& suite) { known.suites.insert(suite[1]); });
    if (!name.ends_with("CMakeLists.txt")) continue;
    for_each_match(text, kTarget, [&](const auto& target) { known.targets.insert(target[1]); });
    for_each_match(text, kProgram, [&](const auto& program) {
      auto& source = known.programs[program[1]];
      for_each_match(program[2].str(), kWord, [&](const auto& word) {
        const auto file = texts.find(name.substr(0, name.rfind('/') + 1) + word.str());
        if (file != texts.end()) source += file->second;
      });
    });
  }
  return known;
}

// Whether a file or folder has this name, in which `*` and words in capitals stand for anything but a slash. A name
// without an ending stands for what begins so: a header and its source, or several files.
bool is_there(const std::string& path, const std::set<std::string>& files) {
  static const std::regex kDots(R"([.+])"), kAnything(R"(\*|\b[A-Z]{2,}|(_)[A-Z]{2,})"), kEnd("/+$");
  const auto name = std::regex_replace(path, kEnd, "");
  if (files.contains(name)) return true;
  const bool has_ending = name.find('.', name.rfind('/') + 1) != std::string::npos;
  auto pattern = std::regex_replace(std::regex_replace(name, kDots, "\\$&"), kAnything, "$1[^/]*");
  if (!has_ending && name == path) pattern += "[^/]*";
  return std::ranges::any_of(files,
                             [named = std::regex(pattern)](const auto& file) { return std::regex_match(file, named); });
}

bool is_placeholder(const std::string& word) {
  return std::ranges::none_of(word, [](unsigned char c) { return std::islower(c) || std::isdigit(c); });
}

// What is wrong with a command line.
std::vector<std::string> faults_of(const std::string& line, const Known& known) {
  std::vector<std::string> found;
  auto words = words_of_command(line);
  static const std::regex kSetting(R"([A-Z_]+=.*)"), kOption(R"((--[a-z][a-z0-9-]*).*)"),
      kFilter(R"(--gtest_filter=(\w+)(.*))");
  while (!words.empty() && (words[0] == "sudo" || std::regex_match(words[0], kSetting))) words.erase(words.begin());
  if (words.empty()) return found;
  auto program = words[0];
  if (program == "./bootstrap" && words.size() > 1 && !is_placeholder(words[1]) && !known.tasks.contains(words[1]))
    found.push_back(fmt::format("bootstrap does not know {}", words[1]));
  if (program == "ninja") {
    for (std::size_t i = 1; i < words.size(); ++i) {
      const bool folder = words[i] == "-C" || words[i - 1] == "-C";
      if (!folder && !words[i].starts_with("-") && !known.targets.contains(words[i]))
        found.push_back(fmt::format("no target {}", words[i]));
    }
  }
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (words[i - 1] == "--preset" && !known.presets.contains(words[i]))
      found.push_back(fmt::format("no preset {}", words[i]));
    std::smatch filter;
    if (std::regex_match(words[i], filter, kFilter) && std::ranges::none_of(known.suites, [&](const auto& suite) {
          return filter[2].str().starts_with("*") ? suite.starts_with(filter[1].str()) : suite == filter[1];
        }))
      found.push_back(fmt::format("no tests {}", words[i]));
  }
  if (program == "systemctl" || program == "journalctl" || program == "systemd-analyze") {
    for (const auto& word : words)
      if (const auto unit = word.substr(0, word.find('*')); unit.starts_with("kasumi") && !known.units.contains(unit))
        found.push_back(fmt::format("no unit {}", word));
  }
  if (program.starts_with("build/")) program = program.substr(6);
  if (program.starts_with("kasumi-") && words.size() > 1) {
    const auto source = known.programs.find(program);
    if (source == known.programs.end()) return found.push_back(fmt::format("no program {}", program)), found;
    const bool has_commands = source->second.find("add_subcommand(") != std::string::npos;
    if (has_commands && source->second.find("add_subcommand(\"" + words[1] + "\"") == std::string::npos)
      found.push_back(fmt::format("{} has no command {}", program, words[1]));
    std::smatch option;
    for (const auto& word : words)
      if (std::regex_match(word, option, kOption) && option[1] != "--help" &&
          source->second.find("\"" + option[1].str() + "\"") == std::string::npos)
        found.push_back(fmt::format("{} has no {}", program, option[1].str()));
  }
  return found;
}

// "PAGE:12: no target test_b" for each name that leads nowhere.
std::vector<std::string> leads_nowhere(const Texts& documents, const Known& known) {
  std::vector<std::string> found;
  static const std::regex kBuilt(R"((?:^|[\s`(])build(?:-[a-z0-9]+)?/([a-z0-9_][a-zA-Z0-9_-]*)(?![a-zA-Z0-9_/.-]))"),
      kPath(R"((?:^|[\s=(])((?:\.ci|base|calib|capture|cmake|docs|estimator|fixtures|gles|history|pipeline|report|)"
            R"(systemd|tests)/[A-Za-z0-9_*./@-]*[A-Za-z0-9_*/])(?![A-Za-z0-9_*/]))");
  for (const auto& [name, text] : documents) {
    for_each_match(text, kBuilt, [&, &name = name, &text = text](const auto& built) {
      if (known.targets.contains(built[1]) || is_placeholder(built[1].str().substr(built[1].str().rfind('_') + 1)))
        return;
      found.push_back(fmt::format("{}:{}: no target {}", name,
                                  std::count(text.begin(), text.begin() + built.position(), '\n') + 1, built[1].str()));
    });
    // What the past had is not here any more.
    if (name == "CHANGELOG.md") continue;
    for (const auto& code : code_in(text)) {
      if (code.block && !code.language.empty()) continue;
      const auto say = [&, &name = name](const std::string& fault) {
        found.push_back(fmt::format("{}:{}: {}", name, code.line, fault));
      };
      for (const auto& line : command_lines_in(code)) {
        for (const auto& fault : faults_of(line, known)) say(fmt::format("{}: {}", line, fault));
        for_each_match(line, kPath, [&](const auto& path) {
          if (!is_there(path[1], known.files)) say(fmt::format("no file {}", path[1].str()));
        });
      }
    }
  }
  return found;
}

Known known_here() {
  const auto files = repository_files();
  auto texts = texts_ending_in(files, {"bootstrap", "CMakePresets.json", "CMakeLists.txt", ".cpp"});
  auto named = files;
  for (const auto& hidden : std::filesystem::directory_iterator(source_folder() / ".ci"))
    named.insert(".ci/" + hidden.path().filename().string());
  return known_in(named, texts);
}

TEST(Commands, NameOnlyWhatIsThere) {
  const auto known = known_here();
  EXPECT_GT(known.tasks.size(), 10u);
  EXPECT_GT(known.presets.size(), 5u);
  EXPECT_GT(known.targets.size(), 20u);
  EXPECT_GT(known.suites.size(), 100u);
  EXPECT_GT(known.units.size(), 10u);
  EXPECT_GT(known.programs.size(), 4u);
  EXPECT_THAT(leads_nowhere(texts_ending_in(repository_files(), {".md"}), known), testing::IsEmpty());
}

TEST(Commands, AnOffenderWouldBeFound) {
  const auto known =
      known_in({"systemd/kasumi.service", "systemd/kiosk/kasumi-stick@.service", "pipeline/lab/haze/command_haze.cpp",
                "docs/sky.md"},
               {{"bootstrap", "case $1 in\n  build)\n    ;;\n  test)\n    ;;\nesac\n"},
                {"CMakePresets.json", "{\"name\": \"debug\"}"},
                {"tools/CMakeLists.txt", "add_executable(kasumi-make main.cpp)\nkasumi_test(test_sky SOURCES a.cpp)\n"},
                {"tools/main.cpp", "app.add_option(\"--out\", out);\napp.add_subcommand(\"run\");\n"},
                {"tests/test_a.cpp", "TEST(Solver, Solves) {}\n"}});
  const auto found = [&](const std::string& text) { return leads_nowhere({{"docs/a.md", text}}, known); };
  for (const std::string good :
       {"`./bootstrap test -R sky`", "    ./bootstrap build && ./bootstrap TASK\n", "`./bootstrap`",
        "    cmake --preset debug && ninja -C build-debug test_sky && build-debug/test_sky  # words\n",
        "`build/test_sky --gtest_filter='Solv*'`", "<!-- figures: SKY by build/test_sky -->", "`build/test_NAME`",
        "`sudo systemctl restart kasumi`", "`journalctl -u 'kasumi-stick@*' -u kasumi.service`",
        "`pipeline/ROOM/PART/command_NAME.cpp`", "`pipeline/lab/haze/`", "`docs/*.md`",
        "`kasumi-make run --out docs/sky.md`", "`kasumi-kiosk`", "`docs/sk`", "`pipeline/*/*/command_`"})
    EXPECT_THAT(found(good), testing::IsEmpty()) << good;
  for (const std::string bad :
       {"`./bootstrap tset`", "    ./bootstrap build && ./bootstrap demo\n", "    cmake --preset quick\n",
        "    ninja -C build test_moon\n", "see build/test_moon\n", "<!-- figures: SKY by build/test_moon -->",
        "`build/test_sky --gtest_filter='Moon*'`", "`build/test_sky --gtest_filter=Solv.Solves`",
        "`sudo systemctl restart kasumi-moon`", "`pipeline/command_NAME.cpp`", "`docs/moon.md`",
        "    kasumi-make run --out docs/moon.md\n", "`kasumi-make walk`", "`kasumi-make run --in x`",
        "    kasumi-moon --out x\n", "`docs/mo`"})
    EXPECT_THAT(found(bad), testing::SizeIs(1)) << bad;
}

}  // namespace
}  // namespace kasumi::house
