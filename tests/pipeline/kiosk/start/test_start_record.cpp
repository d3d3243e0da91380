// How starts that come to nothing are counted, over boots, and what follows from it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/files.hpp"
#include "base/outside/this_boot.hpp"
#include "pipeline/kiosk/start/start_log.hpp"
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

// It began well; then each start died, some as early as in the loader, where nobody could note them.
TEST(StartRecord, Row19ACrashLoopIsAFailureEvenIfPicturesWereShownBeforeAndNotAllStartsAreKnown) {
  StartRecord record;
  note_start(record, "a", 15.0);
  record.shown = true;
  note_start(record, "a", 60.0);
  note_start(record, "a", 90.0);
  note_start(record, "b", 15.0);
  EXPECT_EQ(record.failed_boots, 1);
  EXPECT_THAT(record.why, ElementsAre(HasSubstr("ended without a picture at start 3")));
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

// Starts of one boot, each of which the watchdog ended since that camera's opening hung.
std::vector<double> rests_in_minutes(StartRecord& record, int starts) {
  std::vector<double> minutes;
  for (int start = 0; start < starts; ++start) {
    note_start(record, "a", 4000.0 * start);
    minutes.push_back(rest_s(record, "sky") / 60.0);
    note_hung_opening(record, "sky");
  }
  return minutes;
}

TEST(StartRecord, Row30ACameraThatHangsAtEveryOpeningRestsLongerAndLonger) {
  StartRecord record;
  EXPECT_THAT(rests_in_minutes(record, 10), ElementsAre(0, 1, 2, 4, 8, 16, 32, 60, 60, 60));
  EXPECT_EQ(rest_s(record, "scene"), 0.0) << "the other one is well";
  note_start(record, "a", 50000.0);
  note_opened(record, "sky");
  note_start(record, "a", 51000.0);
  EXPECT_EQ(rest_s(record, "sky"), 0.0) << "it came after all";
}

TEST(StartRecord, Row30WhereAPersonOrABootMayHaveMendedACameraItIsTriedAtOnce) {
  StartRecord record;
  rests_in_minutes(record, 3);
  record.ended = true;  // systemctl restart
  note_start(record, "a", 9000.0);
  EXPECT_EQ(rest_s(record, "sky"), 0.0);
  note_hung_opening(record, "sky");
  note_start(record, "a", 9100.0);
  EXPECT_EQ(rest_s(record, "sky"), 480.0) << "it was not mended";
  note_start(record, "b", 15.0);
  EXPECT_EQ(rest_s(record, "sky"), 0.0) << "without power it forgets";
  note_start(record, "b", 100.0);
  EXPECT_EQ(rest_s(record, "sky"), 480.0);
}

// What a camera does is not the content's fault, and its restarts are too rare for a reboot.
TEST(StartRecord, Row30ACameraThatHangsIsNoReasonForOtherContentOrAReboot) {
  constexpr double kUntilTheWatchdogEndsIt_s = 60.0 + 20.0 + 1.0;
  StartRecord record;
  double now_s = 15.0;
  std::vector<double> starts_s;
  for (int start = 0; start < 12; ++start) {
    note_start(record, "a", now_s);
    starts_s.push_back(now_s);
    record.shown = true;
    EXPECT_FALSE(suspects_content(record)) << start;
    now_s += rest_s(record, "scene") + kUntilTheWatchdogEndsIt_s;
    note_hung_opening(record, "scene");
  }
  for (std::size_t i = kStartsBeforeReboot; i <= starts_s.size(); ++i)
    EXPECT_GT(starts_s[i - 1] - starts_s[i - kStartsBeforeReboot], kStartWindow_s);
  note_start(record, "b", 15.0);
  EXPECT_EQ(record.failed_boots, 0);
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

TEST(StartLog, Row30RemembersOverProcessesWhatHung) {
  const ServiceFolders folders{log_folder("hung"), log_folder("hung-run")};
  for (int start = 0; start < 3; ++start) {
    StartLog log(folders, "a", 100.0 * start);
    EXPECT_EQ(log.record().hung_openings.count("sky"), start > 0 ? 1u : 0u);
    log.opening_hangs("sky");
  }
  StartLog log(folders, "a", 400.0);
  EXPECT_EQ(rest_s(log.record(), "sky"), 240.0);
  log.opened("sky");
  EXPECT_EQ(rest_s(StartLog(folders, "a", 500.0).record(), "sky"), 0.0);
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

// The unit does not reboot where these are; from now on starts are counted here.
TEST(StartLog, Row39AProgramThatBeginsForgetsTheBootsInWhichItNeverDid) {
  const ServiceFolders folders{log_folder("begins"), log_folder("begins-run")};
  ASSERT_TRUE(write_text_file(folders.state / "never-began", "a\nb\nc\n"));
  ASSERT_TRUE(write_text_file(folders.runtime / "no-reboot", ""));
  EXPECT_EQ(StartLog(folders, "c", 12.0).mode(), StartMode::whole);
  EXPECT_FALSE(std::filesystem::exists(folders.state / "never-began"));
  EXPECT_FALSE(std::filesystem::exists(folders.runtime / "no-reboot"));
}

TEST(StartLog, ADamagedRecordOrDiskKeepsNothingFromBeingShown) {
  const ServiceFolders folders{log_folder("damaged"), {}};
  for (const char* text : {"", "[", "{\"failed_boots\": -9, \"starts_s\": \"x\", \"why\": [3], \"mode\": 4}", "[1]",
                           "{\"hung_openings\": 7}", "{\"hung_openings\": {\"sky\": -1, \"scene\": \"x\"}}"}) {
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
