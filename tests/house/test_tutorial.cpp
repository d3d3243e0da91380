// docs/tutorial-code.md: its patches apply to the code as it is now, what they touch compiles (-fsyntax-only, with the
// flags that the build has for the same folder), and what it greps for is found.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <regex>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/outside/json_text.hpp"
#include "tests/house/document_code.hpp"

namespace {

namespace fs = std::filesystem;
using namespace kasumi::house;

struct Ended {
  int code = -1;
  std::string words;
};

Ended ended(const std::string& command) {
  Ended end;
  FILE* pipe = ::popen(("(" + command + ") 2>&1").c_str(), "r");
  if (!pipe) return end;
  std::array<char, 4096> buffer;
  for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) end.words.append(buffer.data(), n);
  end.code = WEXITSTATUS(::pclose(pipe));
  return end;
}

fs::path empty_folder(const std::string& name) {
  const auto folder = kasumi::test_output_folder() / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

std::vector<std::string> patches_in(const std::string& page) {
  std::vector<std::string> patches;
  for (const auto& code : code_in(page))
    if (code.language == "diff") patches.push_back(code.text);
  return patches;
}

std::set<std::string> files_touched(const std::vector<std::string>& patches) {
  static const std::regex kFile(R"(\+\+\+ b/(\S+))");
  std::set<std::string> files;
  for (const auto& patch : patches)
    for (std::sregex_iterator file(patch.begin(), patch.end(), kFile), last; file != last; ++file)
      files.insert((*file)[1]);
  return files;
}

// Copies what the patches touch into `folder` and applies them there, in their order; what `patch` says where it fails.
std::string applied(const std::vector<std::string>& patches, const fs::path& folder) {
  for (const auto& file : files_touched(patches)) {
    fs::create_directories((folder / file).parent_path());
    if (fs::exists(kasumi::source_folder() / file)) fs::copy_file(kasumi::source_folder() / file, folder / file);
  }
  for (const auto& text : patches) {
    std::ofstream(folder / "step.patch") << text;
    const auto done =
        ended(fmt::format("cd {} && patch -p1 --fuzz=0 --no-backup-if-mismatch < step.patch", folder.string()));
    if (done.code != 0) return done.words + text;
  }
  return "";
}

// Each source that the build compiles, by name from the root, with its command; also of those that are compiled together.
std::map<std::string, std::string> commands_by_source() {
  const auto listed = kasumi::read_text_file(kasumi::kasumi_program().parent_path() / "compile_commands.json").value();
  const auto root = kasumi::source_folder().string() + "/";
  std::map<std::string, std::string> commands;
  for (const auto& one : parse_json(listed)) {
    const std::string file = one["file"], command = one["command"];
    if (file.find("/unity/") == std::string::npos) {
      if (file.starts_with(root)) commands[file.substr(root.size())] = command;
      continue;
    }
    static const std::regex kIncluded("#include \"([^\"]+)\"");
    const auto text = kasumi::read_text_file(file).value();
    for (std::sregex_iterator source(text.begin(), text.end(), kIncluded), last; source != last; ++source)
      commands[(*source)[1]] = command;
  }
  return commands;
}

// The command of the source whose path begins most like this one's: its own, or a neighbour's where it is new.
std::string command_for(const std::string& source, const std::map<std::string, std::string>& commands) {
  const auto alike = [&](const std::string& other) {
    return std::mismatch(source.begin(), source.end(), other.begin(), other.end()).first - source.begin();
  };
  const auto nearest =
      std::ranges::max_element(commands, [&](const auto& a, const auto& b) { return alike(a.first) < alike(b.first); });
  return nearest->second;
}

// What the compiler says about the touched sources in `folder`, whose headers go before the repository's.
std::string compiled(const std::set<std::string>& files, const fs::path& folder) {
  static const std::regex kOutput(R"( -o \S+ -c \S+$)"), kHeaders(R"( -Winvalid-pch| -include \S+)"), kFirst("^(\\S+)");
  const auto commands = commands_by_source();
  std::string said;
  for (const auto& file : files) {
    if (!file.ends_with(".cpp")) continue;
    auto command = std::regex_replace(command_for(file, commands), kHeaders, "");
    command = std::regex_replace(command, kFirst, "$1 -I" + folder.string());
    command = std::regex_replace(command, kOutput, " -fsyntax-only " + (folder / file).string());
    const auto done = ended(command);
    if (done.code != 0) said += command + "\n" + done.words;
  }
  return said;
}

std::string tutorial() {
  return kasumi::read_text_file(kasumi::source_folder() / "docs/tutorial-code.md").value();
}

TEST(Tutorial, PatchesApplyAndCompile) {
  const auto patches = patches_in(tutorial());
  ASSERT_GE(patches.size(), 5u);
  const auto folder = empty_folder("tutorial");
  ASSERT_EQ(applied(patches, folder), "");
  const auto touched = files_touched(patches);
  EXPECT_GE(std::ranges::count_if(touched, [](const auto& file) { return file.ends_with(".cpp"); }), 4);
  EXPECT_EQ(compiled(touched, folder), "");
}

TEST(Tutorial, APatchThatIsOutOfDateIsFound) {
  const std::string good = "--- a/LICENSE\n+++ b/LICENSE\n@@ -1,1 +1,1 @@\n-", after = "\n+Nothing\n";
  const auto first = lines_of(kasumi::read_text_file(kasumi::source_folder() / "LICENSE").value()).front();
  EXPECT_EQ(applied({good + first + after}, empty_folder("fresh")), "");
  EXPECT_THAT(applied({good + "what was there once" + after}, empty_folder("stale")), testing::HasSubstr("FAILED"));
  const std::string broken =
      "--- /dev/null\n+++ b/base/broken.cpp\n@@ -0,0 +1 @@\n+int broken( { return undeclared; }\n";
  const auto folder = empty_folder("broken");
  ASSERT_EQ(applied({broken}, folder), "");
  EXPECT_THAT(compiled({"base/broken.cpp"}, folder), testing::HasSubstr("error"));
}

TEST(Tutorial, FindsWhatItGrepsFor) {
  int searches = 0;
  for (const auto& code : code_in(tutorial()))
    for (const auto& line : command_lines_in(code)) {
      if (!line.starts_with("git grep")) continue;
      ++searches;
      EXPECT_EQ(ended(fmt::format("cd {} && {} -- '*.cpp'", kasumi::source_folder().string(), line)).code, 0) << line;
    }
  EXPECT_GE(searches, 2);
}

}  // namespace
