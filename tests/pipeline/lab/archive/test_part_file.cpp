// A part outlives kills and power cuts, and takes no records that are not its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "pipeline/lab/archive/part_file.hpp"
#include "tests/pipeline/lab/archive/made_archive.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

class Part : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
  }
  void put(std::string_view text) const { std::ofstream(file, std::ios::binary) << text; }
  std::string text() const { return read_text_file(file).value_or("unreadable"); }
  Result<PartFile> open(bool resume) const { return PartFile::open(file, {made.archive(), 5, 4}, resume); }
  void expect_refused(std::string_view because) const {
    const auto part = open(true);
    ASSERT_FALSE(part);
    EXPECT_EQ(part.error().kind, FaultKind::bad_input);
    EXPECT_THAT(part.error().message, HasSubstr(because));
  }

  const std::filesystem::path folder = test_folder("part-file"), file = folder / "part.jsonl";
  const MadeArchive made{20};  // this part: pictures 6 to 9
};

TEST_F(Part, HasEachRecordOnceItIsAdded) {
  auto part = open(false);
  ASSERT_TRUE(part) << part.error().message;
  ASSERT_TRUE(part->add(made.record(6)));
  EXPECT_EQ(text(), made.record(6));
  ASSERT_TRUE(part->add(made.record(7)));
  ASSERT_TRUE(part->finish());
  EXPECT_EQ(text(), made.records(6, 7));
}

// A kill or a power cut may leave any number of a record's bytes, or zeros where bytes were not yet written.
TEST_F(Part, ATornRecordIsCutOffWhereverItIsTorn) {
  const auto whole = made.records(6, 7), torn = made.record(8);
  for (std::size_t bytes = 0; bytes < torn.size(); bytes += bytes < 4 || bytes + 4 > torn.size() ? 1 : 37) {
    put(whole + torn.substr(0, bytes));
    auto part = open(true);
    ASSERT_TRUE(part) << part.error().message;
    EXPECT_EQ(part->done(), 2u);
    EXPECT_EQ(part->mended_bytes(), bytes);
    ASSERT_TRUE(part->add(torn));
    EXPECT_EQ(text(), made.records(6, 8));
  }
  put(whole + std::string(4096, '\0'));
  const auto part = open(true);
  ASSERT_TRUE(part);
  EXPECT_EQ(part->done(), 2u);
  EXPECT_EQ(text(), whole);
}

TEST_F(Part, ATornFirstRecordIsCutOff) {
  put(made.record(6).substr(0, 100));
  const auto part = open(true);
  ASSERT_TRUE(part) << part.error().message;
  EXPECT_EQ(part->done(), 0u);
  EXPECT_EQ(text(), "");
}

TEST_F(Part, ResumingAWholePartLeavesItAsItIs) {
  put(made.records(6, 9));
  const auto part = open(true);
  ASSERT_TRUE(part);
  EXPECT_EQ(part->done(), 4u);
  EXPECT_EQ(text(), made.records(6, 9));
}

TEST_F(Part, WithoutResumeNothingIsOverwritten) {
  put(made.records(6, 7));
  const auto part = open(false);
  ASSERT_FALSE(part);
  EXPECT_THAT(part.error().message, HasSubstr("--resume"));
  EXPECT_EQ(text(), made.records(6, 7));
}

TEST_F(Part, WhatIsNotItsOwnIsRefusedAndLeft) {
  put("# Notes\nof a person\n");
  expect_refused("expected records");
  EXPECT_EQ(text(), "# Notes\nof a person\n");
  put(made.records(5, 7));
  expect_refused("another shard");
  put(made.record(6) + made.record(8));
  expect_refused("another shard");
  put(made.records(6, 10));
  expect_refused("another shard");
  put(MadeArchive(21).record(6));
  expect_refused("another list");
  put(archive_record("{}", std::nullopt, "", {6, {20, made.archive().list, "0000000000000000"}}));
  expect_refused("other options");
}

// A requeued task may start before its first run is dead.
TEST_F(Part, OnlyOneProcessWritesIt) {
  const auto first = open(false);
  ASSERT_TRUE(first);
  expect_refused("another process");
}

TEST_F(Part, AFolderThatIsNotThereIsTold) {
  const auto part = PartFile::open(folder / "none/part.jsonl", {made.archive(), 0, 1}, true);
  ASSERT_FALSE(part);
  EXPECT_THAT(part.error().message, HasSubstr("none/part.jsonl"));
}

}  // namespace
}  // namespace kasumi
