// A week in a file that never grows: over the oldest, through power cuts, and whatever else lies there.
#include <gmock/gmock.h>

#include "base/files.hpp"
#include "history/history_ring.hpp"
#include "tests/base/power_cut.hpp"
#include "tests/history/minutes.hpp"
#include "tests/must.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using std::chrono::minutes;

std::filesystem::path fresh_folder(const std::string& name) {
  const auto folder = test_output_folder() / "history" / name;
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

HistoryLine line_of(int i) {
  auto line = whole_line();
  line.utc += minutes{i};
  return line;
}

TEST(HistoryRings, KeepTheLastWeekInOneMegabyte) {
  const auto file = fresh_folder("week") / kHistoryFile;
  constexpr int kWeek = 7 * 24 * 60, kWritten = kWeek + 250;
  // Most of the week is laid there at once, since each minute goes through to the disk.
  ASSERT_TRUE(HistoryRing::open(file));
  auto text = read_text_file(file).value();
  for (int i = 0; i < kWeek; ++i) {
    auto line = line_of(i);
    line.number = static_cast<std::uint32_t>(i + 1);
    text.replace((1 + line.number % kHistoryLines) * kHistoryLineBytes, kHistoryLineBytes, history_text(line));
  }
  ASSERT_TRUE(write_text_file(file, text));
  {
    auto ring = HistoryRing::open(file).value();
    for (int i = kWeek; i < kWritten; ++i) ASSERT_TRUE(ring.append(line_of(i)));
  }
  EXPECT_LE(std::filesystem::file_size(file), kHistoryBytes);
  const auto lines = read_history(file).value();
  ASSERT_EQ(lines.size(), kHistoryLines);
  EXPECT_GE(lines.size(), static_cast<std::size_t>(kWeek));
  for (std::size_t i = 1; i < lines.size(); ++i) ASSERT_EQ(lines[i].utc - lines[i - 1].utc, minutes{1});
  EXPECT_EQ(lines.back().utc, line_of(kWritten - 1).utc);
  // The next start goes on.
  ASSERT_TRUE(HistoryRing::open(file).value().append(line_of(kWritten)));
  EXPECT_EQ(read_history(file).value().back().number, lines.back().number + 1);
}

TEST(HistoryRings, ACutAtAnyMomentLosesOneMinuteAtMost) {
  const auto folder = fresh_folder("cut");
  const auto file = folder / kHistoryFile;
  std::vector<std::size_t> calls_after;  // how many calls had returned when a minute was told to be kept
  PowerCut power(folder);
  {
    auto ring = HistoryRing::open(file).value();
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(ring.append(line_of(i)));
      calls_after.push_back(power.calls());
    }
  }
  const auto found = fresh_folder("found");
  for (const auto left : PowerCut::kAll)
    for (std::size_t calls = 0; calls <= power.calls(); ++calls) {
      power.lay_out(calls, left, found);
      std::size_t kept = 0;
      while (kept < calls_after.size() && calls_after[kept] <= calls) ++kept;
      auto ring = HistoryRing::open(found / kHistoryFile);
      ASSERT_TRUE(ring) << calls;
      const auto lines = read_history(found / kHistoryFile).value();
      EXPECT_GE(lines.size(), kept) << "cut after " << calls << " calls";
      ASSERT_TRUE(ring->append(line_of(100)));
      EXPECT_EQ(read_history(found / kHistoryFile).value().size(), lines.size() + 1);
    }
}

TEST(HistoryRings, TornLinesAreLeftOutAndWrittenOver) {
  const auto file = fresh_folder("torn") / kHistoryFile;
  {
    auto ring = HistoryRing::open(file).value();
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(ring.append(line_of(i)));
  }
  auto text = read_text_file(file).value();
  const auto newest = text.find("a 2026");  // number 10
  ASSERT_NE(newest, std::string::npos);
  text[newest + 30] = 'X';
  ASSERT_TRUE(write_text_file(file, text));
  EXPECT_EQ(read_history(file).value().size(), 9U);
  ASSERT_TRUE(HistoryRing::open(file).value().append(line_of(50)));
  const auto lines = read_history(file).value();
  EXPECT_EQ(lines.size(), 10U);
  EXPECT_EQ(lines.back().number, 10U);
}

TEST(HistoryRings, WhatIsNoHistoryBeginsAnew) {
  const auto file = fresh_folder("other") / kHistoryFile;
  for (const std::string& other :
       {std::string(), std::string("{}"), std::string(kHistoryBytes, 'x'), std::string(3 * kHistoryBytes, '\0')}) {
    ASSERT_TRUE(write_text_file(file, other));
    EXPECT_FALSE(read_history(file));
    ASSERT_TRUE(HistoryRing::open(file).value().append(line_of(0)));
    EXPECT_EQ(read_history(file).value().size(), 1U);
  }
  EXPECT_FALSE(read_history(file.parent_path() / "none"));
  EXPECT_THAT(HistoryRing::open(file.parent_path() / "no/such/folder"),
              FailsWith(testing::HasSubstr("no/such/folder")));
}

// A line copied to another place is not where its number belongs.
TEST(HistoryRings, AForeignLineIsLeftOut) {
  const auto file = fresh_folder("foreign") / kHistoryFile;
  {
    auto ring = HistoryRing::open(file).value();
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(ring.append(line_of(i)));
  }
  auto text = read_text_file(file).value();
  text.replace(100 * kHistoryLineBytes, kHistoryLineBytes, text.substr(2 * kHistoryLineBytes, kHistoryLineBytes));
  ASSERT_TRUE(write_text_file(file, text));
  EXPECT_EQ(read_history(file).value().size(), 3U);
}

}  // namespace
}  // namespace kasumi
