// How starts that come to nothing are counted, over boots, and what follows from it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "pipeline/machine/this_boot.hpp"
#include "pipeline/start/start_log.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// A boot whose every start fails at once, until systemd reboots.
StartMode crash_until_reboot(StartRecord& record, const std::string& boot) {
  const auto mode = note_start(record, boot, 15.0);
  for (int start = 1; start < kStartsBeforeReboot; ++start) {
    record.doing = "opening the display";
    note_start(record, boot, 15.0 + 10.0 * start);
  }
  record.doing = "opening the display";
  return mode;
}

StartRecord after_three_failed_boots() {
  StartRecord record;
  for (const char* boot : {"a", "b", "c"}) EXPECT_EQ(crash_until_reboot(record, boot), StartMode::whole);
  return record;
}

TEST(StartRecord, Row34AfterThreeRebootsForNothingTheFourthBootIsSafeAndSaysWhy) {
  auto record = after_three_failed_boots();
  EXPECT_EQ(note_start(record, "d", 15.0), StartMode::safe);
  EXPECT_EQ(record.failed_boots, 3);
  EXPECT_THAT(record.why, ElementsAre(HasSubstr("10 starts failed within 2 minutes, the last one while opening"),
                                      testing::_, testing::_));
}

// A machine that hangs as a whole is rebooted by its watchdog before there are ten starts.
TEST(StartRecord, Row34ABootWithoutAnyPictureIsAFailureAfterOneStart) {
  StartRecord record;
  for (const char* boot : {"a", "b", "c"}) EXPECT_EQ(note_start(record, boot, 15.0), StartMode::whole);
  EXPECT_EQ(note_start(record, "d", 15.0), StartMode::safe);
  EXPECT_THAT(record.why.back(), HasSubstr("without a picture"));
}

TEST(StartRecord, APowerCutUnderAPictureIsNoFailure) {
  StartRecord record;
  for (int boot = 0; boot < 10; ++boot) {
    EXPECT_EQ(note_start(record, std::to_string(boot), 15.0), StartMode::whole);
    record.shown = true;
  }
  EXPECT_EQ(record.failed_boots, 0);
}

TEST(StartRecord, CrashesThatAreTooRareForARebootAreNoFailedBoot) {
  StartRecord record;
  for (const char* boot : {"a", "b", "c", "d"}) {
    for (int start = 0; start < 50; ++start) {
      EXPECT_EQ(note_start(record, boot, 300.0 * start), StartMode::whole) << "a crash every five minutes";
      record.shown = true;
    }
  }
}

TEST(StartRecord, TenMinutesOfPicturesForgiveEverything) {
  StartRecord record;
  crash_until_reboot(record, "a");
  crash_until_reboot(record, "b");
  note_start(record, "c", 15.0);
  note_well(record);
  EXPECT_EQ(record.failed_boots, 0);
  EXPECT_THAT(record.why, IsEmpty());
  EXPECT_EQ(note_start(record, "d", 15.0), StartMode::whole);
}

TEST(StartRecord, SafeModeLastsThroughPowerCutsAndEndsWhenSomebodyAsksForIt) {
  auto record = after_three_failed_boots();
  note_start(record, "d", 15.0);
  record.shown = true;
  note_well(record);
  EXPECT_EQ(note_start(record, "e", 15.0), StartMode::safe) << "that it shows the still proves nothing";
  record.shown = record.ended = true;  // `systemctl restart`, or its time was up
  EXPECT_EQ(note_start(record, "e", 60.0), StartMode::whole);
  EXPECT_TRUE(record.trial);
  EXPECT_EQ(note_start(record, "e", 70.0), StartMode::safe) << "one failed trial is enough: no reboot for it";
  record.shown = record.ended = true;
  EXPECT_EQ(note_start(record, "e", 90.0), StartMode::whole);
  note_well(record);
  EXPECT_FALSE(record.trial);
  EXPECT_EQ(note_start(record, "f", 15.0), StartMode::whole);
}

TEST(StartRecord, WhenSafeModeFailsAsWellItShowsLessStill) {
  auto record = after_three_failed_boots();
  EXPECT_EQ(crash_until_reboot(record, "d"), StartMode::safe);
  EXPECT_EQ(note_start(record, "e", 15.0), StartMode::plain);
}

TEST(StartRecord, TrialsBecomeRarer) {
  auto record = after_three_failed_boots();
  note_start(record, "d", 15.0);
  std::vector<double> hours;
  for (int trial = 0; trial < 7; ++trial) {
    hours.push_back(safe_for_s(record) / 3600.0);
    record.ended = true;
    note_start(record, "d", 100.0);
    note_start(record, "d", 110.0);
  }
  EXPECT_THAT(hours, ElementsAre(1, 2, 4, 8, 16, 24, 24));
}

TEST(StartRecord, AfterFiveFailedStartsTheContentIsSuspected) {
  StartRecord record;
  for (int start = 0; start < kStartsBeforeKeptContent; ++start) {
    note_start(record, "a", 10.0 * start);
    EXPECT_FALSE(suspects_content(record));
  }
  note_start(record, "a", 100.0);
  EXPECT_TRUE(suspects_content(record));
}

std::filesystem::path log_folder(const std::string& name) {
  const auto folder = test_output_folder() / "pipeline" / ("start-log-" + name);
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

TEST(StartLog, CountsOverProcessesAndBoots) {
  const ServiceFolders folders{log_folder("counts"), log_folder("counts-run")};
  for (const char* boot : {"a", "b", "c"})
    for (int start = 0; start < kStartsBeforeReboot; ++start)
      StartLog(folders, boot, 10.0 * start).doing("reading the content");
  const StartLog last(folders, "d", 12.0);
  EXPECT_EQ(last.mode(), StartMode::safe);
  EXPECT_THAT(last.record().why, testing::Each(HasSubstr("reading the content")));
}

TEST(StartLog, WellLetsTheUnitCountFromTheBeginning) {
  const ServiceFolders folders{log_folder("well"), log_folder("well-run")};
  ASSERT_TRUE(write_text_file(folders.runtime / "starts", "7\n"));
  StartLog log(folders, "a", 12.0);
  log.well();
  EXPECT_FALSE(std::filesystem::exists(folders.runtime / "starts"));
  log.ended();
  EXPECT_EQ(StartLog(folders, "b", 12.0).record().failed_boots, 0);
}

TEST(StartLog, ADamagedRecordOrDiskKeepsNothingFromBeingShown) {
  const ServiceFolders folders{log_folder("damaged"), {}};
  for (const char* text : {"", "[", "{\"failed_boots\": -9, \"starts_s\": \"x\", \"why\": [3], \"mode\": 4}", "[1]"}) {
    ASSERT_TRUE(write_text_file(folders.state / "starts.json", text));
    EXPECT_EQ(StartLog(folders, "a", 12.0).mode(), StartMode::whole) << text;
  }
  EXPECT_EQ(StartLog({"/proc/no such folder", {}}, "a", 12.0).mode(), StartMode::whole);
  EXPECT_EQ(StartLog({}, "a", 12.0).mode(), StartMode::whole) << "by hand nothing is counted";
}

TEST(StartLog, KnowsThisBoot) {
  EXPECT_EQ(boot_id().size(), 36u);
  EXPECT_GT(since_boot_s(), 0.0);
}

}  // namespace
}  // namespace kasumi
