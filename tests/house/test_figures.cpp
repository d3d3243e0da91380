// The figures in the documents: each table of numbers says which command prints it, or whose it is, and
// docs/rewrite-figures puts there what the command prints. Real data that tests want are described for outsiders.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cctype>
#include <cstdlib>
#include <fstream>
#include <regex>

#include <fmt/format.h>

#include "tests/house/repository.hpp"

namespace {

using namespace kasumi::house;
using testing::HasSubstr;
using testing::IsEmpty;

const std::array<std::string, 5> kMeasuringPages{"docs/accuracy.md", "docs/performance.md", "docs/sky.md",
                                                 "docs/physics.md", "docs/photographs.md"};

std::vector<std::string> cells_of(const std::string& row) {
  std::vector<std::string> cells;
  std::istringstream stream(row.substr(1));
  for (std::string cell; std::getline(stream, cell, '|');) cells.push_back(cell);
  return cells;
}

// ".073 to .076", "6.2 %; .0081", "91 of 120": more digits than letters, not words with a number among them.
bool is_figure(const std::string& cell) {
  int digits = 0, letters = 0;
  for (const char c : cell) {
    digits += std::isdigit(static_cast<unsigned char>(c)) != 0;
    letters += std::isalpha(static_cast<unsigned char>(c)) != 0;
  }
  return digits > letters;
}

struct Table {
  int line = 0;  // of its heading
  std::vector<std::string> rows;
  std::string marker;  // the comment that stands before it
  // A column beside the first with figures in at least half of its cells.
  bool of_figures() const {
    std::map<std::size_t, std::pair<int, int>> columns;
    for (std::size_t i = 2; i < rows.size(); ++i) {
      const auto cells = cells_of(rows[i]);
      for (std::size_t c = 1; c < cells.size(); ++c) {
        columns[c].first += is_figure(cells[c]);
        ++columns[c].second;
      }
    }
    for (const auto& [column, count] : columns)
      if (2 * count.first >= count.second && count.first > 0) return true;
    return false;
  }
};

std::vector<Table> tables_of(const std::string& text) {
  std::vector<Table> tables;
  std::string marker;
  bool inside = false;
  int number = 0;
  for (const auto& line : lines_of(text)) {
    ++number;
    if (line.starts_with("|")) {
      if (!inside) tables.push_back({number, {}, marker});
      tables.back().rows.push_back(line);
      inside = true;
      marker.clear();
      continue;
    }
    inside = false;
    if (line.starts_with("<!--"))
      marker = line;
    else if (!line.empty())
      marker.clear();
  }
  return tables;
}

const std::regex kMarker(R"(<!-- (figures: |by hand: |from: ).+ -->)");

std::vector<std::string> tables_of_unknown_origin(const std::string& name, const std::string& text) {
  std::vector<std::string> found;
  for (const Table& table : tables_of(text))
    if (table.of_figures() && !std::regex_match(table.marker, kMarker))
      found.push_back(
          fmt::format("{}:{}: figures, but no <!-- figures: COMMAND -->, <!-- by hand: WHY --> or <!-- from: "
                      "WHOM --> above them",
                      name, table.line));
  return found;
}

TEST(Figures, OfEveryTableSayWhoPrintsThem) {
  const auto texts = texts_ending_in(repository_files(), {kMeasuringPages.begin(), kMeasuringPages.end()});
  ASSERT_EQ(texts.size(), kMeasuringPages.size());
  for (const auto& [name, text] : texts) EXPECT_THAT(tables_of_unknown_origin(name, text), IsEmpty());
}

TEST(Figures, OfAnOffendingTableWouldBeFound) {
  const std::string table = "| T | found |\n|---|---|\n| 2 | 2.01 +- .02 |\n";
  EXPECT_THAT(tables_of_unknown_origin("a.md", table), testing::SizeIs(1));
  EXPECT_THAT(tables_of_unknown_origin("a.md", "<!-- figures: build/kasumi bench -->\n\nwords\n\n" + table),
              testing::SizeIs(1));
  EXPECT_THAT(tables_of_unknown_origin("a.md", "<!-- figures: build/kasumi bench -->\n\n" + table), IsEmpty());
  EXPECT_THAT(tables_of_unknown_origin("a.md", "<!-- from: M Table 1 -->\n" + table), IsEmpty());
  EXPECT_THAT(tables_of_unknown_origin("a.md", "| key | what |\n|---|---|\n| a | Preetham 1999 |\n"), IsEmpty());
}

// A command that is not built, or a table that no source prints, would leave figures to go stale.
TEST(Figures, ArePrintedByProgramsThatExist) {
  const auto files = repository_files();
  std::string lists, sources;
  for (const auto& [name, text] : texts_ending_in(files, {"CMakeLists.txt"})) lists += text;
  for (const auto& [name, text] : texts_ending_in(files, {".cpp", ".hpp"}))
    if (name.starts_with("tests/") && !name.starts_with("tests/house/")) sources += text;
  static const std::regex kFigures(R"(<!-- figures: (?:([a-z0-9-]+) by )?(.+) -->)"), kProgram(R"(build/([\w-]+))");
  int tables = 0;
  for (const auto& [page, text] : texts_ending_in(files, {".md"}))
    for (const auto& line : lines_of(text)) {
      std::smatch marker;
      if (!std::regex_match(line, marker, kFigures)) continue;
      ++tables;
      const std::string name = marker[1], commands = marker[2];
      if (!name.empty()) {
        EXPECT_THAT(sources, HasSubstr("\"" + name + "\"")) << page << ": nobody prints " << line;
      }
      for (std::sregex_iterator program(commands.begin(), commands.end(), kProgram), last; program != last; ++program) {
        const std::string target = (*program)[1];
        EXPECT_TRUE(lists.find("(" + target + "\n") != std::string::npos ||
                    lists.find("(" + target + " ") != std::string::npos)
            << page << ": no program " << target;
      }
    }
  EXPECT_GT(tables, 10);
}

// docs/rewrite-figures over a page, with what a command prints.
struct Rewritten {
  int code = 0;
  std::string page;
};
Rewritten rewritten(const std::string& page, const std::string& options = "") {
  const auto folder = kasumi::test_output_folder();
  std::filesystem::create_directories(folder);
  const auto file = folder / "page.md";
  std::ofstream(file) << page;
  const auto script = kasumi::source_folder() / "docs" / "rewrite-figures";
  const int status =
      std::system(fmt::format("{} {} {} >/dev/null 2>&1", script.string(), options, file.string()).c_str());
  return {WEXITSTATUS(status), kasumi::read_text_file(file).value()};
}

TEST(Figures, AreWrittenIntoTheTablesOfTheDocuments) {
  const std::string before =
      "Words.\n\n<!-- figures: air by echo 'figures of air | noon | 2.5 |'; echo 'figures of air | dusk | 3 |' -->\n\n"
      "| when | T |\n|---|---|\n| dusk | 9 |\n| noon | 9 |\n\nMore | words.\n";
  const auto one = rewritten(before);
  EXPECT_EQ(one.code, 0);
  EXPECT_EQ(one.page.substr(one.page.find("| when")),
            "| when | T |\n|---|---|\n| dusk | 3 |\n| noon | 2.5 |\n\nMore | words.\n");
  EXPECT_EQ(rewritten(one.page).page, one.page) << "again the same";
  EXPECT_EQ(rewritten(before, "--check").code, 1) << "stale";
  EXPECT_EQ(rewritten(before, "--check").page, before);
  EXPECT_EQ(rewritten(one.page, "--check").code, 0);

  const auto whole =
      rewritten("<!-- figures: echo '| a | b |'; echo '|---|---|'; echo '| 1 | 2 |' -->\n\n| old | b |\n");
  EXPECT_THAT(whole.page, HasSubstr("\n| a | b |\n|---|---|\n| 1 | 2 |\n"));
  EXPECT_THAT(whole.page, testing::Not(HasSubstr("old")));
}

TEST(Figures, ThatNobodyPrintsAnyLongerAreNamedAndKept) {
  const auto gone = rewritten(
      "<!-- figures: air by echo 'figures of air | noon | 2 |' -->\n\n| when | T |\n|---|---|\n| noon | 9 |\n| dusk | "
      "9 |\n");
  EXPECT_EQ(gone.code, 1);
  EXPECT_THAT(gone.page, HasSubstr("| noon | 2 |\n| dusk | 9 |\n"));
  EXPECT_EQ(rewritten("<!-- figures: air by true -->\n\n| when | T |\n|---|---|\n| noon | 9 |\n").code, 1);
}

TEST(Figures, OfSentencesReplaceTheWholeTable) {
  const auto said = rewritten(
      "<!-- figures: said by echo 'figures of said | a | in 3 of 4 |'; echo 'figures of said | a | by 2 % |' -->\n\n"
      "| of | what |\n|---|---|\n| a | in 2 of 4 |\n| a | by 1 % |\n");
  EXPECT_EQ(said.code, 0);
  EXPECT_EQ(said.page.substr(said.page.find("| of")), "| of | what |\n|---|---|\n| a | in 3 of 4 |\n| a | by 2 % |\n");
}

// Below a table with goals stands which are missed, by the table as it is.
TEST(Figures, ThatMissTheirGoalAreSaidToBelowTheTable) {
  struct Case {
    std::string heading, rows, said;
  };
  const std::string heading = "| what | found | goal |\n|---|---|---|\n";
  const std::vector<Case> cases{
      {heading, "| noon | 2.8 | 3 |\n| dusk | 3.6 | 3; held to 4.6 |\n| fog | 11.7 | none: supposed |\n",
       "Goals in numbers: 2, missed: 1. *dusk*: 3.6, .6 above."},
      {heading, "| noon | 3.0 | 3 |\n| dusk | 9 | 25.1: by sigma |\n", "Goals in numbers: 2, all met."},
      {heading, "| a | 3 of 4 | all |\n| b | 3 of 4 | >= 80 % |\n| c | 1 of 50 | 2 % |\n| d | .35 | .5 to 2 |\n",
       "Goals in numbers: 4, missed: 3. *a*: 3 of 4 instead of all; *b*: 3 of 4, 5.0 % below; *d*: .35, .15 below."},
      {heading, "| a | 10; .060 +- .03; .123 | >= 9; .09 +- .03; .09 +- .03 |\n| b | .4; 2.5 | 2 |\n",
       "Goals in numbers: 5, missed: 2. *a*: .123, .003 above; *b*: 2.5, .5 above."},
      {heading, "| a | 1.2 | <= 1.2: **missed** |\n",
       "Goals in numbers: 1, missed: 1. *a*: 1.2, by less than its last digit."},
      {heading, "| a | 5.3; 6.8 | 4: bound 4.5; 7: bound 5.8 |\n| b | 1 of 3 | all: bound 2 of 3, at any scale |\n",
       "Goals in numbers: 3, missed: 2. *a*: 5.3, 1.3 above (bound 4.5); *b*: 1 of 3 instead of all (bound 2 of 3, at "
       "any\n"
       "scale)."},
      {"| what | given | found | goal, given |\n|---|---|---|---|\n", "| a | 2 | 9 | 3 |\n",
       "Goals in numbers: 1, all met."},
      {heading, "| a | 158 | 90 % |\n", ""},
      {"| what | found |\n|---|---|\n", "| a | 2 |\n", ""}};
  std::string before, after;
  for (const auto& c : cases) {
    const std::string table = "<!-- figures: air by false -->\n\n" + c.heading + c.rows, words = "\nWords.\n\n";
    before += table + words;
    after += table;
    if (!c.said.empty())
      after += "\n<!-- goals: written by docs/rewrite-figures -->\n" + c.said + "\n<!-- end of goals -->\n";
    after += words;
  }
  const auto written = rewritten(before, "--sentences");
  EXPECT_EQ(written.code, 0);
  EXPECT_EQ(written.page, after);
  EXPECT_EQ(rewritten(after, "--sentences").page, after) << "again the same";
  EXPECT_EQ(rewritten(after, "--sentences --check").code, 0);
  std::string better = after;
  better.replace(better.find("| 3.6 |"), 7, "| 2.6 |");
  EXPECT_EQ(rewritten(better, "--sentences --check").code, 1) << "stale";
}

TEST(Figures, OfTheDocumentsThatMissTheirGoalAreSaidTo) {
  const auto script = kasumi::source_folder() / "docs" / "rewrite-figures";
  EXPECT_EQ(std::system((script.string() + " --sentences --check").c_str()), 0)
      << "docs/rewrite-figures --sentences writes what the tables say now";
}

// A figure from ctest's log, of a test in two shards.
TEST(Figures, AreTakenFromALogOfTheTests) {
  const auto log = kasumi::test_output_folder() / "LastTest.log";
  std::filesystem::create_directories(log.parent_path());
  std::ofstream(log) << "Start testing: now\n"
                     << std::string(58, '-') << "\n1/2 Testing: test_air.1of2\nfigures of air | noon | 2 |\n"
                     << std::string(58, '-') << "\n2/2 Testing: test_air.2of2\nfigures of air | dusk | 3 |\n";
  const auto one = rewritten("<!-- figures: air by build/test_air -->\n\n| when | T |\n|---|---|\n",
                             fmt::format("--log {}", log.string()));
  EXPECT_EQ(one.code, 0);
  EXPECT_THAT(one.page, HasSubstr("| noon | 2 |\n| dusk | 3 |\n"));
}

// What tests ask of the folder of real data, docs/data.md describes.
TEST(Figures, OfRealDataSayWhereTheDataAre) {
  const auto files = repository_files();
  const std::string page = texts_ending_in(files, {"docs/data.md"}).at("docs/data.md");
  static const std::regex kWanted(R"re((?:shared_data_folder\(\)|shared_data) / "([^"]+)"(?: / "([^"]+)")?)re");
  int wanted = 0;
  for (const auto& [name, text] : texts_ending_in(files, {".cpp", ".hpp"}))
    for (std::sregex_iterator use(text.begin(), text.end(), kWanted), last; use != last; ++use) {
      std::string path = (*use)[1];
      if ((*use)[2].matched) path += "/" + (*use)[2].str();
      ++wanted;
      // The folder, or a file in a folder that is described.
      const bool described =
          page.find("`" + path) != std::string::npos ||
          page.find("`" + std::filesystem::path(path).parent_path().string() + "/`") != std::string::npos;
      EXPECT_TRUE(described) << name << " wants " << path << ", of which docs/data.md says nothing";
    }
  EXPECT_GT(wanted, 10);
}

}  // namespace
