// The walls between rooms and between a room's sub-rooms, and the libraries' doors: what a file may include
// (walls.hpp).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fnmatch.h>

#include <algorithm>

#include <fmt/format.h>

#include "tests/house/source_files.hpp"
#include "tests/house/walls.hpp"

namespace kasumi::house {
namespace {

// Whether the table allows it for the two folders themselves.
bool allowed(const std::string& folder, const std::string& other) {
  const auto walls = kMayInclude.find(folder);
  return walls != kMayInclude.end() && walls->second.contains(other);
}

// The rooms around the two are compared from the outermost inwards; the first that differ decide.
bool may_include(const std::string& folder, const std::string& other) {
  if (folder == other) return true;
  const auto depth = [](const std::string& name) { return 1 + std::ranges::count(name, '/'); };
  for (int level = 1;; ++level) {
    const std::string room = room_at(folder, level), other_room = room_at(other, level);
    if (room != other_room || level > std::max(depth(folder), depth(other))) return allowed(room, other_room);
  }
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
  EXPECT_THAT(violations("pipeline/show/scene/a.cpp", "#include \"gles/scene.hpp\"\n"), IsEmpty());
  EXPECT_THAT(violations("pipeline/show/scene/a.cpp", "#include \"pipeline/show/stage/stage.hpp\"\n"), SizeIs(1));
  EXPECT_THAT(violations("pipeline/show/scene/a.cpp", "#include \"pipeline/machine/progress.hpp\"\n"), SizeIs(1));
  EXPECT_THAT(violations("pipeline/kiosk/past/a.cpp", "#include \"pipeline/show/scene/for_gles.hpp\"\n"), IsEmpty());
  EXPECT_THAT(violations("pipeline/lab/sky/a.cpp", "#include \"pipeline/kiosk/start/starts.hpp\"\n"), SizeIs(1));
  EXPECT_THAT(violations("pipeline/lab/sky/a.cpp", "#include \"pipeline/lab/bench/bench.hpp\"\n"), SizeIs(1));
  EXPECT_THAT(violations("pipeline/lab/sky/a.cpp", "#include \"pipeline/command.hpp\"\n"), IsEmpty());
  EXPECT_THAT(violations("pipeline/site/config/a.cpp", "#include \"pipeline/command.hpp\"\n"), SizeIs(1));
  EXPECT_THAT(violations("pipeline/show/stage/a.cpp", "#include \"pipeline/show/scene/scene_air.hpp\"\n"), IsEmpty());
  EXPECT_THAT(violations("calib/mask/a.cpp", "#include \"calib/camera.hpp\"\n"), IsEmpty());
  EXPECT_THAT(violations("calib/board/a.cpp", "#include \"calib/camera.hpp\"\n"), SizeIs(1));
  EXPECT_THAT(violations("pipeline/lab/sky/command_sky.cpp", "#include <CLI/CLI.hpp>\n"), IsEmpty());
  EXPECT_THAT(violations("pipeline/lab/sky/sky_options.cpp", "#include <CLI/CLI.hpp>\n"), SizeIs(1));
  EXPECT_THAT(violations("pipeline/lab/sky/a.cpp", "#include \"estimator/papers/reference_pixel.hpp\"\n"), IsEmpty());
  EXPECT_THAT(violations("pipeline/show/scene/a.cpp", "#include \"estimator/papers/reference_pixel.hpp\"\n"),
              SizeIs(1));
  EXPECT_THAT(violations("gles/anteroom/a.cpp", ""), SizeIs(1));
}

// A topological order exists, or a cycle would be allowed.
TEST(IncludeDirections, TheWallsAllowNoCircle) {
  std::set<std::string> settled;
  for (bool more = true; more;) {
    more = false;
    for (const auto& [folder, allowed] : kMayInclude) {
      const auto is_settled = [&](const std::string& other) {
        return settled.contains(other) || folder.starts_with(other + "/");
      };
      if (!settled.contains(folder) && std::ranges::all_of(allowed, is_settled)) more = settled.insert(folder).second;
    }
  }
  EXPECT_EQ(settled.size(), kMayInclude.size());
}

}  // namespace
}  // namespace kasumi::house
