#include <gtest/gtest.h>

#include <filesystem>

#include "base/files.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

std::filesystem::path folder() {
  const auto path = test_output_folder() / "files";
  std::filesystem::create_directories(path);
  return path;
}

TEST(Files, WhatIsWrittenIsReadBack) {
  const auto path = folder() / "a.txt";
  ASSERT_TRUE(write_text_file(path, "old"));
  ASSERT_TRUE(write_text_file(path, "new"));
  EXPECT_EQ(read_text_file(path).value(), "new");
}

TEST(Files, AFailedWriteLeavesTheOldFileAndNothingElse) {
  const auto path = folder() / "kept" / "b.txt";
  std::filesystem::remove_all(path.parent_path());
  std::filesystem::create_directories(path.parent_path());
  ASSERT_TRUE(write_text_file(path, "old"));
  const auto result = replace_file(path, [](const std::filesystem::path& temporary) -> Result<> {
    (void)write_text_file(temporary, "half");
    return fail(FaultKind::io, "disk full");
  });
  EXPECT_FALSE(result);
  EXPECT_EQ(read_text_file(path).value(), "old");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path.parent_path()), {}), 1);
}

TEST(Files, AMissingFileIsNamed) {
  const auto result = read_file("/nowhere/at-all");
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, FaultKind::bad_input);
  EXPECT_NE(result.error().message.find("/nowhere/at-all"), std::string::npos);
}

TEST(Files, AFolderIsNotAFile) {
  EXPECT_FALSE(read_file("/tmp"));
}

}  // namespace
}  // namespace kasumi
