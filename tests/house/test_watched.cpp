// What the address sanitizer does not watch (cmake/sanitizers.cmake) reads nothing that comes from outside.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "base/files.hpp"
#include "tests/house/source_files.hpp"

namespace kasumi::house {
namespace {

using Names = std::set<std::string>;

std::string sanitizer_rules() {
  return read_text_file(source_folder() / "cmake/sanitizers.cmake").value();
}

// The words of the first set(NAME ...), which for KASUMI_NOT_WATCHED is the address sanitizer's.
Names set_in(const std::string& rules, const std::string& name) {
  const auto start = rules.find("set(" + name);
  if (start == std::string::npos) return {};
  const auto begin = start + name.size() + 4;
  std::istringstream words(rules.substr(begin, rules.find(')', begin) - begin));
  Names found;
  for (std::string word; words >> word;) found.insert(word);
  return found;
}

struct Watching {
  Names folders;  // not watched
  Names solvers;
};

Watching watching() {
  const auto rules = sanitizer_rules();
  Watching found{set_in(rules, "KASUMI_NEVER_WATCHED"), set_in(rules, "KASUMI_SOLVERS")};
  found.folders.merge(set_in(rules, "KASUMI_NOT_WATCHED"));
  return found;
}

bool begins_with_one_of(const std::string& text, const Names& beginnings) {
  return std::ranges::any_of(beginnings, [&](const auto& beginning) { return text.starts_with(beginning); });
}

bool is_watched(const std::string& file, const Watching& watching) {
  const auto holds = [&](const std::string& folder) { return file.starts_with(folder + "/"); };
  return !watching.solvers.contains(file) && std::ranges::none_of(watching.folders, holds);
}

// What reads files, pictures, models, archives, devices and servers: libraries, and our tables' text.
const Names kReaders = {
    "OpenEXR/",   "archive",  "base/table/",       "curl/",           "draco/",       "jpeglib.h", "lcms2.h",
    "libcamera/", "libexif/", "linux/videodev2.h", "meshoptimizer.h", "microhttpd.h", "nlohmann/", "opencv2/imgcodecs",
    "png.h",      "sodium",   "sqlite3.h",         "tiny_gltf.h",     "toml++/",      "webp/",     "zlib.h",
    "zstd.h"};
const Names kSolvers = {"Eigen/", "ceres/"};

// They read nothing of strangers.
const Names kReadTheirOwn = {
    "fixtures/",                                       // the repository's own buildings and tables
    "pipeline/install/calibration_report/report.cpp",  // a table that calib has read
    "pipeline/lab/bench/recorded_run.cpp",             // an earlier bench of the same person
    "pipeline/lab/comparison/command_compare.cpp",     // writes
    "pipeline/lab/prove/proof_json.cpp",               // writes
};

bool includes_one_of(const SourceFile& file, const Names& headers) {
  return std::ranges::any_of(file.includes, [&](const auto& each) { return begins_with_one_of(each.target, headers); });
}

std::vector<std::string> readers_not_watched(const std::vector<SourceFile>& files, const Watching& watching) {
  std::vector<std::string> found;
  for (const auto& file : files)
    if (!is_watched(file.name, watching) && !begins_with_one_of(file.name, kReadTheirOwn) &&
        includes_one_of(file, kReaders))
      found.push_back(file.name);
  return found;
}

std::vector<SourceFile> all_rooms() {
  std::vector<SourceFile> files;
  for (const auto* room :
       {"base", "calib", "capture", "estimator", "fixtures", "gles", "history", "pipeline", "report"})
    for (auto& file : source_files(room)) files.push_back(std::move(file));
  return files;
}

TEST(Watched, WhatReadsForeignBytesIsWatched) {
  const auto files = all_rooms();
  EXPECT_THAT(readers_not_watched(files, watching()), testing::IsEmpty());
  EXPECT_GT(std::ranges::count_if(files, [](const auto& file) { return includes_one_of(file, kReaders); }), 50);
}

TEST(Watched, AReaderThatIsLeftOutWouldBeFound) {
  const auto files = all_rooms();
  for (const auto* folder :
       {"base/picture_files", "capture/v4l2", "gles/model", "pipeline/kiosk/content", "report/web"}) {
    auto less = watching();
    less.folders.insert(folder);
    EXPECT_THAT(readers_not_watched(files, less), testing::Not(testing::IsEmpty())) << folder;
  }
  auto less = watching();
  less.solvers.insert("calib/lens/key_file.cpp");
  EXPECT_THAT(readers_not_watched(files, less), testing::ElementsAre("calib/lens/key_file.cpp"));
}

// Those not named would cost the address stage ten seconds each; a name of no file is left behind.
TEST(Watched, SolversAreNamed) {
  const auto known = watching();
  ASSERT_THAT(known.solvers, testing::Not(testing::IsEmpty()));
  std::vector<std::string> missing, left = {known.solvers.begin(), known.solvers.end()};
  for (const auto& file : all_rooms()) {
    if (!file.name.ends_with(".cpp")) continue;
    if (includes_one_of(file, kSolvers) && is_watched(file.name, known)) missing.push_back(file.name);
    std::erase(left, file.name);
  }
  EXPECT_THAT(missing, testing::IsEmpty());
  EXPECT_THAT(left, testing::IsEmpty());
}

}  // namespace
}  // namespace kasumi::house
