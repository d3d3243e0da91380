// status.json as it lies on a disk: absent, silent, or not what it should be.
#include <gmock/gmock.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/files.hpp"
#include "report/diagnosis/diagnosis.hpp"
#include "tests/places.hpp"
#include "tests/report/told.hpp"

namespace kasumi::report {
namespace {

using namespace std::chrono_literals;

class StatusWatches : public testing::Test {
 protected:
  StatusWatches() {
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
  }
  ~StatusWatches() override {
    std::filesystem::remove_all(folder);
  }  // one of them is a file of 1 TB, most of it a hole
  const std::filesystem::path folder = test_output_folder() / "status-watch";
  const std::filesystem::path file = folder / "status.json";
  ManualClock clock{std::chrono::sys_days{std::chrono::year{2026} / 6 / 21}};
  StatusWatch watch{file, clock};

  void write(const std::string& text) { ASSERT_TRUE(write_text_file(file, text)); }
};

TEST_F(StatusWatches, AFileThatChangesIsHeard) {
  EXPECT_EQ(watch.look().contact, Contact::absent);
  for (int second = 0; second < 60; ++second) {
    write(changed(kGoodStatus, "9000", std::to_string(9000 + second)));
    clock.advance(1s);
    ASSERT_EQ(watch.look().contact, Contact::heard) << second;
  }
  std::filesystem::remove(file);
  EXPECT_EQ(watch.look().contact, Contact::stopped) << "the service manager takes it away with the service";
  clock.advance(kStopPassesBy);
  EXPECT_EQ(watch.look().contact, Contact::absent);
}

// A machine whose time, and whose processes, the test knows.
struct KnownMachine {
  double since_boot_s = 5000.0;
  bool runs = true;
  std::string boot = "this-boot";
  ThisMachine machine() {
    return {boot, [this] { return since_boot_s; }, [this](double) { return runs; }};
  }
};

std::string told_at(double since_boot_s, const std::string& boot = "this-boot") {
  return changed(kGoodStatus, "{",
                 fmt::format("{{\"boot\": \"{}\", \"since_boot_s\": {}, \"pid\": 4711, ", boot, since_boot_s));
}

// `kasumi-report show` looks once.
TEST_F(StatusWatches, Row45AFirstLookKnowsHowOldItIs) {
  KnownMachine known;
  const auto first = [&] { return StatusWatch(file, clock, known.machine()).look(); };
  write(told_at(4999.0));
  EXPECT_EQ(first().contact, Contact::heard);
  known.runs = false;
  EXPECT_EQ(first().contact, Contact::heard) << "the one that follows it has a moment";
  known.since_boot_s = 5006.0;
  EXPECT_EQ(first().contact, Contact::silent) << "killed";
  EXPECT_THAT(first().why, testing::HasSubstr("has gone"));
  known.runs = true;
  EXPECT_EQ(first().contact, Contact::heard);
  known.since_boot_s = 5038.0;
  EXPECT_EQ(first().contact, Contact::silent) << "hung";
  write(told_at(5037.0, "another-boot"));
  EXPECT_EQ(first().contact, Contact::silent);
  clock.advance(24h);
  write(told_at(5037.0));
  EXPECT_EQ(first().contact, Contact::heard) << "whatever the clock was set to";
}

// The reporter's unit hides /proc/sys from it (ProcSubset=pid).
TEST_F(StatusWatches, Row45AMachineThatDoesNotNameItsBootKnowsTheAgeAllTheSame) {
  KnownMachine known{.boot = ""};
  const auto first = [&] { return StatusWatch(file, clock, known.machine()).look(); };
  write(told_at(4999.0));
  EXPECT_EQ(first().contact, Contact::heard);
  known.since_boot_s = 5038.0;
  EXPECT_EQ(first().contact, Contact::silent) << "hung";
  known.since_boot_s = 5006.0;
  known.runs = false;
  EXPECT_EQ(first().contact, Contact::silent) << "killed";
}

TEST_F(StatusWatches, Row45AStopOnPurposeIsNoFaultForTenMinutes) {
  KnownMachine known;
  auto stopped = changed(told_at(5000.0), "\"shown\": \"live\"", "\"shown\": \"nothing\"");
  stopped = changed(stopped, "\"reason\": \"\"", "\"reason\": \"stopped\"");
  write(stopped);
  known.runs = false;
  known.since_boot_s = 5540.0;
  const auto heard = StatusWatch(file, clock, known.machine()).look();
  EXPECT_EQ(heard.contact, Contact::stopped);
  EXPECT_EQ(diagnose(heard).sight, Sight::stopped);
  EXPECT_TRUE(diagnose(heard).symptoms.empty());
  known.since_boot_s = 5700.0;
  EXPECT_EQ(StatusWatch(file, clock, known.machine()).look().contact, Contact::silent);
}

TEST_F(StatusWatches, AFileThatStaysTheSameIsSilence) {
  write(kGoodStatus);
  EXPECT_EQ(watch.look().contact, Contact::heard);
  clock.advance(kSilent);
  EXPECT_EQ(watch.look().contact, Contact::heard);
  clock.advance(1s);
  const auto heard = watch.look();
  EXPECT_EQ(heard.contact, Contact::silent);
  EXPECT_FALSE(heard.status) << "what is old is not shown as if it were so now";
  write(changed(kGoodStatus, "9000", "9001"));
  EXPECT_EQ(watch.look().contact, Contact::heard);
}

// What lies in the kiosk's folder is the kiosk's choice: it must lead nowhere else, and hold nobody up.
TEST_F(StatusWatches, LinksPipesFoldersAndGiantsAreRefused) {
  write(kGoodStatus);
  const auto real = folder / "real.json";
  std::filesystem::rename(file, real);
  std::filesystem::create_symlink(real, file);
  EXPECT_EQ(watch.look().contact, Contact::unreadable);
  std::filesystem::remove(file);

  ASSERT_EQ(::mkfifo(file.c_str(), 0644), 0);
  EXPECT_EQ(watch.look().contact, Contact::unreadable) << "and it did not wait for a writer";
  std::filesystem::remove(file);

  std::filesystem::create_directory(file);
  EXPECT_EQ(watch.look().contact, Contact::unreadable);
  std::filesystem::remove(file);

  std::filesystem::create_symlink("/dev/zero", file);
  EXPECT_EQ(watch.look().contact, Contact::unreadable);
  std::filesystem::remove(file);

  write("{}");
  ASSERT_EQ(::truncate(file.c_str(), off_t{1} << 40), 0);  // a hole: takes no room
  const auto heard = watch.look();
  EXPECT_EQ(heard.contact, Contact::unreadable);
  EXPECT_THAT(heard.why, testing::HasSubstr("larger than"));
}

}  // namespace
}  // namespace kasumi::report
