// Presses by hour: added up, kept for 13 months, and read from whatever is in the file.
#include "pipeline/kiosk/visitor/visitor_presses.hpp"

#include <gtest/gtest.h>

#include "base/files.hpp"
#include "tests/pipeline/recorded.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

std::filesystem::path new_folder(const std::string& name) {
  const auto folder = test_folder(name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

constexpr Utc kPressedAt = std::chrono::sys_days{std::chrono::June / 21 / 2026} + 12h;

TEST(VisitorPresses, AreAddedByHourAndKeptForThirteenMonths) {
  const auto file = new_folder("visitor-presses") / kPressesFile;
  ASSERT_TRUE(add_presses(file, {{kPressedAt, {1, 0, 2, 0, 0, 0}}}, kPressedAt + 5min));
  ASSERT_TRUE(
      add_presses(file, {{kPressedAt, {1, 1, 0, 0, 0, 0}}, {kPressedAt + 1h, {0, 0, 0, 3, 0, 4}}}, kPressedAt + 65min));
  EXPECT_EQ(read_text_file(file).value(),
            "hour_utc,then_and_now,era,language,large_print,story,view\n"
            "2026-06-21T12:00:00Z,2,1,2,0,0,0\n"
            "2026-06-21T13:00:00Z,0,0,0,3,0,4\n");
  ASSERT_TRUE(add_presses(file, {}, kPressedAt + 396 * 24h + 1min));
  EXPECT_EQ(read_presses(read_text_file(file).value()).size(), 1U);
}

TEST(VisitorPresses, AFileThatIsNoneBeginsAnew) {
  const auto file = new_folder("visitor-presses-damaged") / kPressesFile;
  ASSERT_TRUE(write_text_file(file,
                              "hour_utc\n2026-06-21T12:00:00Z,1,2,3,4\n2026-06-21T12:30:00Z,1,2,3,4,5\n,,,,,\n"
                              "2026-06-21T11:00:00Z,1,2,3,4,99999999999999999999\n2026-06-21T10:00:00Z,1,2,3,4,-5\n"
                              "2126-06-21T10:00:00Z,1,2,3,4,5\n\n2026-06-21T09:00:00Z,1,2,3,4,5"));
  ASSERT_TRUE(add_presses(file, {{kPressedAt, {1, 0, 0, 0, 0}}}, kPressedAt));
  EXPECT_EQ(read_presses(read_text_file(file).value()),
            (PressesByHour{{kPressedAt - 3h, {1, 2, 3, 4, 5, 0}}, {kPressedAt, {1, 0, 0, 0, 0}}}));
}

}  // namespace
}  // namespace kasumi
