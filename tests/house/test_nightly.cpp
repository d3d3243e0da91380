// The nightly's scripts over made-up logs, fuzzers and pictures: what they write down, and that they fail where they are to.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <regex>

#include <fmt/format.h>

#include "tests/house/repository.hpp"

namespace {

namespace fs = std::filesystem;
using namespace kasumi::house;
using namespace std::string_literals;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;

struct Said {
  int code = -1;
  std::string words;
};

// In the repository's folder, through bash.
Said said_by(const std::string& command) {
  const auto script = kasumi::test_output_folder() / "command";
  std::ofstream(script) << "cd " << kasumi::source_folder() << "\n" << command << "\n";
  Said said;
  FILE* pipe = ::popen(fmt::format("bash {} 2>&1", script.string()).c_str(), "r");
  if (!pipe) return said;
  std::array<char, 4096> buffer;
  for (std::size_t n; (n = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) said.words.append(buffer.data(), n);
  said.code = WEXITSTATUS(::pclose(pipe));
  return said;
}

fs::path fresh_folder(const std::string& name) {
  const auto folder = kasumi::test_output_folder() / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

std::string text_of(const fs::path& file) {
  return kasumi::read_text_file(file).value();
}

// The words of "NAME=(...)" in a script.
std::set<std::string> words_of(const std::string& script, const std::string& name) {
  const auto begin = script.find("\n" + name + "=(") + name.size() + 3;
  std::istringstream words(script.substr(begin, script.find(')', begin) - begin));
  return {std::istream_iterator<std::string>(words), {}};
}

TEST(Pictures, AreAllDrawn) {
  const auto script = text_of(kasumi::source_folder() / "docs/make-pictures");
  const auto drawn = words_of(script, "all");
  std::set<std::string> kept;
  for (const auto& entry : fs::directory_iterator(kasumi::source_folder() / "docs/pictures"))
    if (entry.path().extension() == ".jpg") kept.insert(entry.path().stem().string());
  EXPECT_EQ(drawn, kept);
  for (const auto& name : drawn) EXPECT_THAT(script, HasSubstr("\n" + name + "() {\n"));
}

TEST(Pictures, ThatTheCodeNoLongerDrawsAreNamed) {
  if (said_by("identify -version | grep ImageMagick").code != 0) GTEST_SKIP() << "ImageMagick is not installed";
  const auto folder = fresh_folder("pictures");
  const auto made = said_by(
      fmt::format("cd {} && mkdir drawn kept && convert -size 320x240 gradient:navy-orange -fill maroon -draw 'circle "
                  "160,120 200,120' "
                  "a.png && for name in again gone moved size; do convert a.png -quality 88 kept/$name.jpg; done\n"
                  "convert a.png -quality 80 drawn/again.jpg; convert a.png -roll +2+0 -quality 88 drawn/moved.jpg\n"
                  "convert a.png -resize 50% drawn/size.jpg",
                  folder.string()));
  ASSERT_EQ(made.code, 0) << made.words;
  const auto compared = said_by(fmt::format("docs/compare-pictures {0}/drawn {0}/kept", folder.string()));
  EXPECT_EQ(compared.code, 1);
  EXPECT_TRUE(std::regex_search(
      compared.words,
      std::regex("again.jpg: mean 0\\.\\d\\d, worst block \\d\\.\\d\\d: as it is kept\n"
                 "gone.jpg: not drawn here\nmoved.jpg: mean \\d\\.\\d\\d, worst block \\d\\d\\.\\d\\d: CHANGED\n"
                 "size.jpg: CHANGED, another size\n"
                 "4 pictures, 1 as they are kept, 2 changed, 1 not drawn here\n")))
      << compared.words;
  fs::remove(folder / "kept/moved.jpg");
  fs::remove(folder / "kept/size.jpg");
  EXPECT_EQ(said_by(fmt::format("docs/compare-pictures {0}/drawn {0}/kept", folder.string())).code, 0);
}

}  // namespace
