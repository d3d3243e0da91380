// No folder holds too many files, and each header's name is unique.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "tests/house/source_files.hpp"
#include "tests/house/walls.hpp"

namespace kasumi::house {
namespace {

constexpr int kMostFilesInFolder = 40;

std::vector<SourceFile> all_code() {
  std::vector<SourceFile> files = source_files("tests");
  for (const auto& [folder, allowed] : kMayInclude) {
    if (folder != room_of(folder)) continue;
    const auto more = source_files(folder);
    files.insert(files.end(), more.begin(), more.end());
  }
  return files;
}

TEST(Folders, NoneIsFlat) {
  std::map<std::string, int> count;
  for (const SourceFile& file : all_code()) ++count[file.folder];
  for (const auto& [folder, files] : count) EXPECT_LE(files, kMostFilesInFolder) << folder;
}

TEST(Folders, AHeadersNameMeansOneThing) {
  std::map<std::string, std::vector<std::string>> places;
  for (const SourceFile& file : all_code())
    if (file.name.ends_with(".hpp")) places[file.name.substr(file.folder.size() + 1)].push_back(file.folder);
  for (const auto& [name, folders] : places) EXPECT_THAT(folders, testing::SizeIs(1)) << name;
}

}  // namespace
}  // namespace kasumi::house
