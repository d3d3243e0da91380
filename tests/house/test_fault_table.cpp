// docs/faults.md names the tests of each row, and lists every test that is named after a row.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include <fmt/format.h>

#include "tests/house/repository.hpp"

namespace {

using namespace kasumi::house;
using Holders = std::map<int, std::set<std::string>>;  // the suites that test each row; "vm": the virtual machine

// The suites in code spans of each row's last cell.
Holders told_in(const std::string& table) {
  Holders told;
  static const std::regex kRow(R"(^\| ([0-9]+) \|.*\|([^|]*)\|$)"), kSuite("`([A-Za-z0-9]+)`");
  for (const auto& line : lines_of(table)) {
    std::smatch row;
    if (!std::regex_match(line, row, kRow)) continue;
    auto& suites = told[std::stoi(row[1])];
    const std::string cell = row[2];
    for (std::sregex_iterator suite(cell.begin(), cell.end(), kSuite), last; suite != last; ++suite)
      suites.insert((*suite)[1]);
  }
  return told;
}

// Tests named by a row: TEST_F(Faults, Row6...) and, in the virtual machine, test_06_...
Holders named_in(const Texts& tests, std::set<std::string>& suites) {
  Holders named;
  static const std::regex kTest(R"(\bTEST(?:_[FP])?\(\s*(\w+),\s*(?:Row([0-9]+))?)"), kVm(R"(def test_([0-9]+)_)");
  for (const auto& [name, text] : tests) {
    const bool vm = name.ends_with(".py");
    for (std::sregex_iterator test(text.begin(), text.end(), vm ? kVm : kTest), last; test != last; ++test) {
      const std::string suite = vm ? "vm" : (*test)[1].str(), row = (*test)[vm ? 1 : 2];
      suites.insert(suite);
      if (!row.empty() && std::stoi(row) > 0) named[std::stoi(row)].insert(suite);
    }
  }
  return named;
}

std::vector<std::string> differences(const std::string& table, const Texts& tests) {
  std::set<std::string> suites;
  auto told = told_in(table);
  std::vector<std::string> found;
  for (const auto& [row, holders] : named_in(tests, suites))
    for (const auto& suite : holders)
      if (!told[row].contains(suite)) found.push_back(fmt::format("row {} does not name {}", row, suite));
  for (const auto& [row, holders] : told)
    for (const auto& suite : holders)
      if (!suites.contains(suite)) found.push_back(fmt::format("row {} names {}, which is not a suite", row, suite));
  return found;
}

TEST(FaultTable, NamesTheTestsThatHoldItsRows) {
  const auto files = repository_files();
  auto tests = texts_ending_in(files, {".cpp", ".py"});
  std::erase_if(tests, [](const auto& file) {
    const auto& name = file.first;
    return !name.starts_with(name.ends_with(".py") ? "tests/vm/" : "tests/") || name.starts_with("tests/house/");
  });
  const auto table = texts_ending_in(files, {"docs/faults.md"}).at("docs/faults.md");
  EXPECT_GT(told_in(table).size(), 20u);
  EXPECT_THAT(differences(table, tests), testing::IsEmpty());
}

TEST(FaultTable, AnOffenderWouldBeFound) {
  const std::string table = "| 1 | unplugged | still | `Faults`, `vm` |\n| 2 | stalled | held | no test |\n";
  EXPECT_THAT(told_in(table), testing::SizeIs(2));
  const Texts tests{{"a.cpp", "TEST_F(Faults, Row1Unplugged) {}\nTEST(Sky, IsBlue) {}\n"},
                    {"test_appliance.py", "    def test_00_is_live(self):\n    def test_01_unplugged(self):\n"}};
  EXPECT_THAT(differences(table, tests), testing::IsEmpty());
  EXPECT_THAT(differences(table, {{"a.cpp", "TEST(Faults, Row2Stalls) {}"}, {"b.py", "def test_01_"}}),
              testing::ElementsAre("row 2 does not name Faults"));
  EXPECT_THAT(differences(table, {{"a.cpp", "TEST(Sky, Row1)"}, {"b.py", "def test_01_"}}),
              testing::UnorderedElementsAre("row 1 does not name Sky", "row 1 names Faults, which is not a suite"));
}

}  // namespace
