// The walls between rooms and between a room's sub-rooms, and the libraries' doors: what a file may include
// (walls.hpp).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fnmatch.h>

#include <fmt/format.h>

#include "tests/house/source_files.hpp"
#include "tests/house/walls.hpp"

namespace kasumi::house {
namespace {

bool may_include(const std::string& folder, const std::string& other) {
  if (folder == other) return true;
  const std::string room = room_of(folder), other_room = room_of(other);
  if (room != other_room) return kMayInclude.at(room).contains(other_room);
  const auto walls = kMayInclude.find(folder);
  return walls != kMayInclude.end() && walls->second.contains(other);
}

bool is_at_home(const std::string& file, const std::set<std::string>& doors) {
  for (const auto& door : doors)
    if (::fnmatch((door + "*").c_str(), file.c_str(), 0) == 0) return true;
  return false;
}

std::vector<std::string> violations(const SourceFile& file) {
  std::vector<std::string> found;
  const auto offends = [&](const std::string& target) {
    found.push_back(fmt::format("{} includes {}", file.name, target));
  };
  if (!kMayInclude.contains(file.folder)) found.push_back(fmt::format("{} lies in no room", file.name));
  for (const auto& [target, ours] : file.includes) {
    const std::string other = folder_of(target);
    if (ours && kMayInclude.contains(room_of(other)) && !may_include(file.folder, other)) offends(target);
    for (const auto& [library, doors] : kLibraryDoors)
      if (target.starts_with(library) && !is_at_home(file.name, doors)) offends(target);
  }
  return found;
}

std::vector<std::string> violations(const std::string& name, const std::string& text) {
  std::istringstream lines(text);
  return violations(source_file(name, lines));
}

TEST(IncludeDirections, NoFileReachesThroughAWall) {
  std::vector<std::string> found;
  int files = 0;
  for (const auto& [folder, allowed] : kMayInclude) {
    if (folder != room_of(folder)) continue;
    for (const SourceFile& file : source_files(folder)) {
      if (!file.name.ends_with(".cpp") && !file.name.ends_with(".hpp")) continue;
      const auto more = violations(file);
      found.insert(found.end(), more.begin(), more.end());
      ++files;
    }
  }
  EXPECT_THAT(found, testing::IsEmpty());
  EXPECT_GT(files, 100);
}

TEST(IncludeDirections, AnOffenderWouldBeFound) {
  using testing::IsEmpty, testing::SizeIs;
  EXPECT_THAT(violations("gles/gl/a.cpp", "#include \"estimator/sky/sun.hpp\"\n"), SizeIs(1));
  EXPECT_THAT(violations("base/a.hpp", "  # include \"calib/lens/lens.hpp\"\n"), SizeIs(1));
  EXPECT_THAT(violations("capture/a.cpp", "#include <ceres/ceres.h>\n"), SizeIs(1));
  EXPECT_THAT(violations("pipeline/scene/a.cpp", "#include \"gles/scene.hpp\"\n"), IsEmpty());
  EXPECT_THAT(violations("pipeline/scene/a.cpp", "#include \"pipeline/stage/stage.hpp\"\n"), SizeIs(1));
  EXPECT_THAT(violations("pipeline/stage/a.cpp", "#include \"pipeline/scene/scene_air.hpp\"\n"), IsEmpty());
  EXPECT_THAT(violations("calib/mask/a.cpp", "#include \"calib/camera.hpp\"\n"), IsEmpty());
  EXPECT_THAT(violations("calib/board/a.cpp", "#include \"calib/camera.hpp\"\n"), SizeIs(1));
  EXPECT_THAT(violations("pipeline/sky/command_sky.cpp", "#include <CLI/CLI.hpp>\n"), IsEmpty());
  EXPECT_THAT(violations("pipeline/sky/sky_options.cpp", "#include <CLI/CLI.hpp>\n"), SizeIs(1));
  EXPECT_THAT(violations("gles/anteroom/a.cpp", ""), SizeIs(1));
}

// A topological order exists, or a cycle would be allowed.
TEST(IncludeDirections, TheWallsAllowNoCircle) {
  std::set<std::string> settled;
  for (bool more = true; more;) {
    more = false;
    for (const auto& [folder, allowed] : kMayInclude) {
      const auto is_settled = [&](const std::string& other) {
        return settled.contains(other) || room_of(other) != room_of(folder);
      };
      if (!settled.contains(folder) && std::ranges::all_of(allowed, is_settled)) more = settled.insert(folder).second;
    }
  }
  EXPECT_EQ(settled.size(), kMayInclude.size());
}

TEST(IncludeDirections, NoPurposeOfTheProgramLeansOnAnother) {
  for (const auto& vertical : kVerticals) {
    const auto exception = kVerticalsMayInclude.find(vertical);
    for (const auto& other : kMayInclude.at(vertical)) {
      if (!kVerticals.contains(other)) continue;
      EXPECT_TRUE(exception != kVerticalsMayInclude.end() && exception->second.contains(other))
          << vertical << ", " << other;
    }
  }
  for (const auto& [folder, allowed] : kMayInclude) {
    if (kVerticals.contains(folder)) continue;
    for (const auto& other : allowed) EXPECT_FALSE(kVerticals.contains(other)) << folder << ", " << other;
  }
}

}  // namespace
}  // namespace kasumi::house
