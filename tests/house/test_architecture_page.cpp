// docs/architecture.md shows the structure that the tests enforce, and stays one page.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/house/source_files.hpp"
#include "tests/house/walls.hpp"

namespace kasumi::house {
namespace {

std::vector<std::string> page() {
  std::ifstream text(source_folder() / "docs/architecture.md");
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) lines.push_back(line);
  return lines;
}

// The texts between backticks.
std::vector<std::string> in_backticks(const std::string& text) {
  static const std::regex quotes("`([^`]+)`");
  std::vector<std::string> found;
  for (std::sregex_iterator match(text.begin(), text.end(), quotes), end; match != end; ++match)
    found.push_back((*match)[1]);
  return found;
}

// Rows of the rooms' table: `folder/` | what it owns | what it may include. A room's sub-rooms stand below it, without
// its name.
Walls walls_of_page() {
  Walls walls;
  std::string room;
  static const std::regex row(R"(^\| (\*\*)?`([\w]+)/`(\*\*)? \|.*\|([^|]*)\|$)");
  for (const std::string& line : page()) {
    std::smatch match;
    if (!std::regex_match(line, match, row)) continue;
    const bool is_room = match[1].matched;
    if (is_room) room = match[2];
    auto& allowed = walls[is_room ? room : room + "/" + match[2].str()];
    static const std::regex word(R"(\w+)");
    const std::string cell = match[4];
    for (std::sregex_iterator name(cell.begin(), cell.end(), word), end; name != end; ++name) {
      const std::string inner = room + "/" + name->str();
      allowed.insert(kMayInclude.contains(inner) ? inner : name->str());
    }
  }
  return walls;
}

TEST(ArchitecturePage, IsOnePageOfLinesThatFit) {
  EXPECT_LE(page().size(), 130U);
  for (const std::string& line : page()) EXPECT_LE(line.size(), 120U) << line;
}

TEST(ArchitecturePage, ShowsTheWallsThatAreTested) {
  EXPECT_EQ(walls_of_page(), kMayInclude);
}

// The paragraph has them as: `headers` in `door`, `door`; ...
TEST(ArchitecturePage, NamesTheLibrariesDoorsThatAreTested) {
  std::string paragraph;
  for (const std::string& line : page()) {
    if (line.starts_with("**Libraries"))
      paragraph = " ";
    else if (line.empty() && !paragraph.empty())
      break;
    if (!paragraph.empty()) paragraph += line + " ";
  }
  Walls doors;
  std::istringstream items(paragraph.substr(paragraph.find(": ") + 1));
  for (std::string item; std::getline(items, item, ';');) {
    const auto names = in_backticks(item);
    ASSERT_GE(names.size(), 2U) << item;
    doors[names.front()].insert(names.begin() + 1, names.end());
  }
  EXPECT_EQ(doors, kLibraryDoors);
}

}  // namespace
}  // namespace kasumi::house
