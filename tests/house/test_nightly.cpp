// The gate's and the nightly's scripts over made-up logs, fuzzers and pictures: what they write down, and that they fail where they are to.
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

TEST(Nightly, HasARowForEachStageAndACommand) {
  const auto script = text_of(kasumi::source_folder() / ".ci/nightly");
  std::set<std::string> commands, rows;
  static const std::regex kCommand(R"(\n  \[([a-z0-9-]+)\]=)"), kRow(R"(\n\| ([a-z0-9-]+) \| (?!last run))");
  const auto page = text_of(kasumi::source_folder() / "docs/nightly.md");
  for (std::sregex_iterator at(script.begin(), script.end(), kCommand), last; at != last; ++at)
    commands.insert((*at)[1]);
  for (std::sregex_iterator at(page.begin(), page.end(), kRow), last; at != last; ++at) rows.insert((*at)[1]);
  EXPECT_EQ(words_of(script, "all"), commands);
  EXPECT_EQ(rows, commands);
  EXPECT_GT(commands.size(), 10U);
}

TEST(Nightly, WritesDownWhatItsStagesSaid) {
  const auto folder = fresh_folder("record");
  std::ofstream(folder / "page.md")
      << "| stage | last run | result | clock | processor | counted |\n|---|---|\n"
         "| fuzz | never | | | | |\n| browser | never | | | | |\n| rauc | never | | | | |\n"
         "| mutations | 2026-11-01 | passed | 1 s | 1 s | 9 noticed |\n";
  std::ofstream(folder / "lists.md")
      << "# Lists\n\n## fuzz\n\nHostile inputs so far: 100 (goal: 1000).\n\n| reader | inputs | clock | "
         "|\n|---|---|---|---|\n"
         "| gone | 7 | 1 s | nothing found |\n\n## mutations\n\nWhat survived.\n\n"
         "| promise | file | |\n|---|---|---|\n| old | a.cpp | SURVIVED |\n\n## bench\n\n"
         "| what | was | is | more |\n|---|---|---|---|\n| kept | 1 | 2 | 100 % |\n";
  std::ofstream(folder / "fuzz")
      << "== 3 s: compiling\nfuzz_edid: 3000 inputs in 12 s, nothing found\n"
         "fuzz_table: 20 inputs in 5 s, FOUND something (the log's end; the input is named in it):\nSUMMARY: x\n"
         "2 readers, 3020 inputs, fewest: table 20\n";
  std::ofstream(folder / "mutations")
      << "noticed     12 s  A day is a day (base/a.cpp) Days.Are\nSURVIVED     9 s  Either a | b (base/b.cpp) \n"
         "useless      0 s  Gone (base/c.cpp) its line occurs 0 times\n"
         "81 noticed, 1 survived (1.2 %), 1 of no use, tried in 21 s\n";
  const auto done =
      said_by(fmt::format("source .ci/stages; cd {0}; stage fuzz sh -c 'cat fuzz; exit 1'; stage mutations cat "
                          "mutations; stage browser sh -c 'exit "
                          "77'\n{1}/.ci/record \"$logs\" page.md lists.md fuzz mutations browser rauc",
                          folder.string(), kasumi::source_folder().string()));
  EXPECT_EQ(done.code, 0) << done.words;
  const auto page = text_of(folder / "page.md");
  const std::string today = R"(\d{4}-\d\d-\d\d)";
  for (const std::string& row :
       {R"(\| fuzz \| )" + today +
            R"( \| FAILED \(1\) \| \d+ s \| \d+ s \| 2 readers, 3020 inputs, fewest: table 20 \|)",
        R"(\| browser \| )" + today + R"( \| skipped \| \d+ s \| \d+ s \|  \|)",
        R"(\| mutations \| )" + today +
            R"( \| passed \| \d+ s \| \d+ s \| 81 noticed, 1 survived \(1.2 %\), 1 of no use, tried in 21 s \|)"})
    EXPECT_TRUE(std::regex_search(page, std::regex("\n" + row + "\n"))) << row << "\n" << page;
  EXPECT_THAT(page, HasSubstr("\n| rauc | never | | | | |\n"));
  EXPECT_EQ(text_of(folder / "lists.md"),
            "# Lists\n\n## fuzz\n\nHostile inputs so far: 3120 (goal: 1000).\n\n| reader | inputs | clock | "
            "|\n|---|---|---|---|\n| edid | 3000 | 12 s | nothing found |\n"
            "| table | 20 | 5 s | FOUND something |\n\n## mutations\n\nWhat survived.\n\n| promise | file | |\n"
            "|---|---|---|\n| Either a \\| b | base/b.cpp | SURVIVED |\n"
            "| Gone | base/c.cpp | useless its line occurs 0 times |\n\n## bench\n\n"
            "| what | was | is | more |\n|---|---|---|---|\n| kept | 1 | 2 | 100 % |\n");
}

TEST(Nightly, AStageWithoutARowOnThePageIsNamed) {
  const auto folder = fresh_folder("record-new");
  std::ofstream(folder / "page.md") << "| old | never | | | | |\n";
  std::ofstream(folder / "lists.md") << "";
  const auto done = said_by(fmt::format(
      "source .ci/stages; stage new true; .ci/record \"$logs\" {0}/page.md {0}/lists.md new", folder.string()));
  EXPECT_EQ(done.code, 1);
  EXPECT_THAT(done.words, HasSubstr("page.md has no row for new"));
}

TEST(Fuzzing, KnowsEveryReader) {
  const auto folder = kasumi::source_folder() / "tests/fuzz";
  std::set<std::string> sources, listed, compiled;
  for (const auto& entry : fs::directory_iterator(folder))
    if (const auto name = entry.path().filename().string(); name.starts_with("fuzz_"))
      sources.insert(name.substr(5, name.size() - 9));
  for (const auto& line : lines_of(text_of(folder / "readers"))) {
    std::istringstream fields(line);
    std::string reader;
    int least = 0, longest = 0;
    if (line.starts_with("#") || !(fields >> reader >> least >> longest)) continue;
    listed.insert(reader);
    EXPECT_EQ(least, reader == "caption" || reader == "content" ? 10'000 : 1'000'000) << reader;
    EXPECT_GE(longest, reader == "toml" ? 1 << 20 : 1 << 14) << reader;
  }
  const auto lists = text_of(folder / "CMakeLists.txt");
  for (const auto& name : sources) {
    if (std::regex_search(lists, std::regex("[a-z]+/" + name + "[ )\n]"))) compiled.insert(name);
  }
  EXPECT_EQ(listed, sources);
  EXPECT_EQ(compiled, sources);
}

// tests/fuzz/run beside three readers, the last one of long inputs, and programs that say what libFuzzer says: as many inputs
// as they are asked for, at most `most`.
fs::path fake_fuzzers(const std::string& name, const std::string& first_lines) {
  const auto folder = fresh_folder(name);
  const auto real = kasumi::source_folder() / "tests/fuzz";
  for (const char* script : {"run", "long"}) fs::copy_file(real / script, folder / script);
  fs::create_symlink(real / "seeds", folder / "seeds");
  std::ofstream(folder / "readers") << "# reader least longest first\ncaption 500 16384 tf\nedid 8000 16384 -\n"
                                       "table 8000 20000 sh\n";
  std::ofstream(folder / "fake") << "#!/bin/sh\nmost=9000\n"
                                 << first_lines
                                 << "\nfor each in \"$@\"; do case $each in -runs=*) runs=${each#-runs=};; esac; done\n"
                                    "[ $runs -ge 0 ] && [ $runs -le $most ] || runs=$most\n"
                                    "echo \"stat::number_of_executed_units: $runs\"\n";
  fs::permissions(folder / "fake", fs::perms::owner_all);
  for (const char* reader : {"caption", "edid", "table"}) fs::create_symlink("fake", folder / ("fuzz_"s + reader));
  return folder;
}

Said fuzzed(const fs::path& folder, const std::string& how) {
  return said_by(fmt::format("KASUMI_JOBS=2 {0}/run {0} {1}", folder.string(), how));
}

TEST(Fuzzing, GoesOnToTheLeastNumberOfInputs) {
  const auto folder = fake_fuzzers("fuzz-least", "");
  const auto shortly = fuzzed(folder, "1 100");
  EXPECT_EQ(shortly.code, 0) << shortly.words;
  EXPECT_THAT(shortly.words, AllOf(HasSubstr("fuzz_edid: 100 inputs in "), HasSubstr("fuzz_table: 9100 inputs in ")));
  const auto whole = fuzzed(folder, "1 100 60");
  EXPECT_EQ(whole.code, 0) << whole.words;
  EXPECT_THAT(whole.words, AllOf(HasSubstr("fuzz_caption: 500 inputs in "), HasSubstr("fuzz_edid: 8000 inputs in "),
                                 HasSubstr("fuzz_table: 17000 inputs in "),
                                 HasSubstr("\n3 readers, 25500 inputs, fewest: caption 500\n")));
}

TEST(Fuzzing, FailsBelowTheLeastNumberAndNamesTheReader) {
  const auto folder = fake_fuzzers("fuzz-few", "case $0 in *caption) most=70;; esac");
  EXPECT_EQ(fuzzed(folder, "1 100").code, 0) << "not asked for";
  const auto few = fuzzed(folder, "1 100 60");
  EXPECT_EQ(few.code, 1);
  EXPECT_THAT(few.words, AllOf(HasSubstr("fuzz_edid: 8000 inputs in "), HasSubstr("fewest: caption 140\n")));
  EXPECT_TRUE(std::regex_search(few.words, std::regex("fuzz_caption: 140 inputs in \\d+ s, FEWER than 500\n")))
      << few.words;
}

TEST(Fuzzing, FailsWhenAReaderFallsOrIsMissing) {
  const auto folder = fake_fuzzers("fuzz-falls", "case $0 in *edid) echo 'ERROR: deadly signal'; exit 77;; esac");
  const auto falls = fuzzed(folder, "1 9");
  EXPECT_EQ(falls.code, 1);
  EXPECT_THAT(falls.words, AllOf(ContainsRegex("fuzz_edid: 0 inputs in [0-9]+ s, FOUND something"),
                                 HasSubstr("\nERROR: deadly signal\n"), HasSubstr("fuzz_caption: 9 inputs in ")));
  fs::remove(folder / "fuzz_edid");
  EXPECT_EQ(fuzzed(folder, "1 9").code, 0);
  const auto missing = fuzzed(folder, "1 9 60");
  EXPECT_EQ(missing.code, 1);
  EXPECT_THAT(missing.words, HasSubstr("fuzz_edid: not built, SKIPPED"));
}

TEST(Fuzzing, MakesLongInputsAsLongAsTheyMayBe) {
  const auto folder = fresh_folder("long");
  const auto made = said_by(fmt::format("tests/fuzz/long toml {}", folder.string()));
  ASSERT_EQ(made.code, 0) << made.words;
  int checked = 0;
  for (const auto& entry : fs::directory_iterator(folder)) {
    EXPECT_LE(entry.file_size(), 1u << 20) << entry.path();
    EXPECT_GE(entry.file_size(), 1'048'000u) << entry.path();
    ++checked;
  }
  EXPECT_GT(checked, 10);
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

// Two stages over the costs of another day.
TEST(Gate, TellsWhatGrewByMoreThanATenthAndTheDearestAndFailsForNone) {
  const auto folder = fresh_folder("costs");
  const auto write = [&](const std::string& name, const std::string& text) { std::ofstream(folder / name) << text; };
  write("test.row", "test       passed          700 s     1400 s  2300 passed, 0 failed, 12 skipped\n");
  write("address.row", "address    FAILED (1)      300 s      500 s  800 passed, 1 failed, 0 skipped\n");
  write("processor.json", R"({"test_a": 50.0, "test_b": 10.4, "test_c": 3.0, "test_d": 0.4})");
  write("before.json", R"({"processor": "another", "measured": "2026-11-01",
                          "stages": {"test": {"clock_s": 600, "processor_s": 1200}, "address": {"processor_s": 490}},
                          "programs": {"test": {"test_a": 30.0, "test_b": 10.0, "test_d": 0.1}}})");
  const auto said = said_by(fmt::format(".ci/costs {0} {0}/before.json {0}/now.json test={0}", folder.string()));
  EXPECT_EQ(said.code, 0) << said.words;
  EXPECT_THAT(said.words,
              ContainsRegex("processor time:\n +50 s  test_a .test.\n +10 s  test_b .test.\n +3 s  test_c"));
  const auto grown = said.words.substr(said.words.find("Grew"));
  EXPECT_THAT(grown, AllOf(HasSubstr("2026-11-01, which was measured on another machine"),
                           HasSubstr("1200 -> 1400 s  stage test"), HasSubstr("30 -> 50 s  test_a (test)"),
                           HasSubstr("Not measured then:\n       3 s  test_c (test)")));
  EXPECT_THAT(grown,
              testing::Not(testing::AnyOf(HasSubstr("test_b"), HasSubstr("test_d"), HasSubstr("stage address"))));

  const auto again = said_by(fmt::format(".ci/costs {0} {0}/now.json {0}/later.json test={0}", folder.string()));
  EXPECT_EQ(again.code, 0) << again.words;
  EXPECT_THAT(again.words, testing::Not(testing::AnyOf(HasSubstr("Grew"), HasSubstr("Not measured"))))
      << "all as before";
  EXPECT_EQ(said_by(fmt::format(".ci/costs {0} {0}/none.json {0}/first.json test={0}", folder.string())).code, 0);
}

}  // namespace
