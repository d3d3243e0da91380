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

// Rows of the rooms' table: `folder/` | what it owns | what it may include. A room's sub-rooms stand below it, without
// its name; those of a room of `pipeline` with that room's.
Walls walls_of_page() {
  Walls walls;
  std::string room;
  static const std::regex row(R"(^\| (\*\*)?`([\w/]+)/`(\*\*)? \|.*\|([^|]*)\|$)");
  for (const std::string& line : page()) {
    std::smatch match;
    if (!std::regex_match(line, match, row)) continue;
    const bool is_room = match[1].matched;
    if (is_room) room = match[2];
    const std::string folder = is_room ? room : room + "/" + match[2].str();
    auto& allowed = walls[folder];
    static const std::regex word(R"(\w+)");
    const std::string cell = match[4];
    for (std::sregex_iterator name(cell.begin(), cell.end(), word), end; name != end; ++name) {
      const std::string beside = folder_of(folder) + "/" + name->str(), within = folder + "/" + name->str();
      allowed.insert(kMayInclude.contains(beside) ? beside : kMayInclude.contains(within) ? within : name->str());
    }
  }
  return walls;
}

TEST(ArchitecturePage, IsOnePageOfLinesThatFit) {
  EXPECT_LE(page().size(), 120U);
  for (const std::string& line : page()) EXPECT_LE(line.size(), 120U) << line;
}

TEST(ArchitecturePage, ShowsTheWallsThatAreTested) {
  EXPECT_EQ(walls_of_page(), kMayInclude);
}

}  // namespace
}  // namespace kasumi::house
