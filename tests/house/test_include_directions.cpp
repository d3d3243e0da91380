// The rooms' walls: a file may include only from its own room and from the rooms named here (docs/architecture.md).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "tests/places.hpp"

namespace {

using Rooms = std::map<std::string, std::set<std::string>>;

const Rooms kMayInclude = {
    {"base", {}},
    {"calib", {"base"}},
    {"capture", {"base"}},
    {"estimator", {"base", "calib"}},
    {"gles", {"base"}},
    {"fixtures", {"base", "calib", "capture"}},
    {"pipeline", {"base", "calib", "capture", "estimator", "gles"}},
};

// Libraries that serve one purpose stay behind the files that serve it.
const std::map<std::string, std::set<std::string>> kLibraryHomes = {
    {"ceres/", {"estimator/", "calib/", "fixtures/atmosphere/"}},
    {"toml++/", {"base/config_table"}},
    {"opencv2/calib3d", {"calib/board.cpp"}},
    {"opencv2/aruco", {"calib/charuco.cpp"}},
    {"tiny_gltf.h", {"gles/", "fixtures/"}},
    {"SDL", {"gles/window"}},
    {"erfa", {"estimator/sun"}},
    {"jpeglib.h", {"capture/"}},
    {"ft2build.h", {"pipeline/caption.cpp"}},
    {"date/", {"pipeline/opening_hours.cpp"}},
    {"systemd/", {"pipeline/notifier"}},
    {"libcamera/", {"capture/libcamera_"}},
    {"linux/videodev2.h", {"capture/v4l2_"}},
    {"linux/v4l2-controls.h", {"capture/v4l2_"}},
    {"xf86drm", {"gles/kms_drm"}},
    {"drm", {"gles/kms_drm"}},
    {"gbm.h", {"gles/kms_scanout_gbm.cpp"}},
    {"libudev.h", {"gles/kms_udev.cpp"}},
    {"EGL/", {"gles/"}},
    {"GLES2/", {"gles/", "pipeline/bench"}},
};

std::vector<std::string> violations(const std::string& room, const std::string& file, const std::string& text) {
  std::vector<std::string> found;
  static const std::regex include(R"(^\s*#\s*include\s*([<"])([^>"]+)[>"])");
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (!std::regex_search(line, match, include)) continue;
    const std::string target = match[2];
    const auto slash = target.find('/');
    const auto other = target.substr(0, slash);
    if (match[1] == "\"" && slash != std::string::npos && kMayInclude.contains(other)) {
      if (other != room && !kMayInclude.at(room).contains(other))
        found.push_back(fmt::format("{} includes {}", file, target));
    }
    for (const auto& [library, homes] : kLibraryHomes) {
      if (!target.starts_with(library)) continue;
      bool at_home = false;
      for (const auto& home : homes) at_home = at_home || file.starts_with(home);
      if (!at_home) found.push_back(fmt::format("{} includes {}", file, target));
    }
  }
  return found;
}

TEST(IncludeDirections, NoRoomReachesThroughAWall) {
  const std::filesystem::path root = kasumi::source_folder();
  std::vector<std::string> found;
  int files = 0;
  for (const auto& [room, allowed] : kMayInclude) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root / room)) {
      const auto extension = entry.path().extension();
      if (extension != ".cpp" && extension != ".hpp") continue;
      std::ifstream file(entry.path());
      const std::string text((std::istreambuf_iterator<char>(file)), {});
      const auto name = std::filesystem::relative(entry.path(), root).string();
      const auto more = violations(room, name, text);
      found.insert(found.end(), more.begin(), more.end());
      ++files;
    }
  }
  EXPECT_THAT(found, testing::IsEmpty());
  EXPECT_GT(files, 10);
}

TEST(IncludeDirections, AnOffenderWouldBeFound) {
  EXPECT_THAT(violations("gles", "gles/a.cpp", "#include \"estimator/sun.hpp\"\n"), testing::SizeIs(1));
  EXPECT_THAT(violations("base", "base/a.hpp", "  # include \"calib/lens.hpp\"\n"), testing::SizeIs(1));
  EXPECT_THAT(violations("capture", "capture/a.cpp", "#include <ceres/ceres.h>\n"), testing::SizeIs(1));
  EXPECT_THAT(violations("pipeline", "pipeline/a.cpp", "#include \"gles/scene.hpp\"\n"), testing::IsEmpty());
}

}  // namespace
