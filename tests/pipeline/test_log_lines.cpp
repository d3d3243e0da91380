// What is said: with its priority, and not without end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include <spdlog/logger.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include "pipeline/kiosk/appliance/camera_link.hpp"
#include "pipeline/log_lines.hpp"
#include "pipeline/machine/mode_log.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

class Lines : public testing::Test {
 protected:
  Lines() { sink->set_pattern("%v"); }
  std::vector<std::string> take() {
    std::vector<std::string> lines;
    std::istringstream text(out.str());
    for (std::string line; std::getline(text, line);) lines.push_back(line);
    out.str({});
    return lines;
  }
  std::ostringstream out;
  std::shared_ptr<spdlog::sinks::ostream_sink_mt> sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(out);
  ManualClock clock{Utc{}};
  spdlog::logger bounded{"bounded", bounded_lines(sink, clock)};
};

TEST_F(Lines, TheJournalGetsThePriorityOfEachLine) {
  sink->set_formatter(journal_formatter());
  spdlog::logger logger("journal", sink);
  logger.info("shown: live");
  logger.warn("display: lost: no connector");
  logger.error("refused:\nkasumi.toml: one\nkasumi.toml: two\n");
  EXPECT_THAT(take(), ElementsAre("<6>kasumi: info: shown: live", "<4>kasumi: warning: display: lost: no connector",
                                  "<3>kasumi: error: refused:", "<3>kasumi.toml: one", "<3>kasumi.toml: two"));
}

TEST_F(Lines, OutagesNowAndThenAreAllTold) {
  for (int day = 0; day < 3; ++day)
    for (int i = 0; i < 8; ++i, clock.advance(3h)) bounded.warn("display: lost: {}", i);
  EXPECT_EQ(take().size(), 24u);
}

// A connector with a bad contact: lost and back every four seconds, and another thing goes wrong once.
TEST_F(Lines, ADayOfFlappingIsBoundedAndTheRestIsHeard) {
  for (int i = 0; i < 21600; ++i) {
    bounded.warn("display: lost: no connector");
    bounded.info("display: 1920x1080");
    if (i == 9000) bounded.warn("sky camera: lost: unplugged");
    clock.advance(4s);
    bounded.flush();
  }
  const auto lines = take();
  EXPECT_LE(lines.size(), 20u + 144u + 1u);
  EXPECT_GE(lines.size(), 144u) << "that it goes on is told";
  EXPECT_THAT(lines, testing::Contains("sky camera: lost: unplugged"));
  EXPECT_THAT(lines.back(), HasSubstr("left out"));
}

TEST_F(Lines, TheNewestLineIsHowItIs) {
  for (int i = 0; i < 50; ++i) bounded.warn("display: lost: {}", i);
  bounded.info("display: back");
  EXPECT_EQ(take().size(), 20u);
  bounded.flush();
  EXPECT_TRUE(take().empty()) << "not yet";
  clock.advance(10min);
  bounded.flush();
  EXPECT_THAT(take(), ElementsAre("display: back (30 earlier lines left out)"));
  clock.advance(10min);
  bounded.flush();
  EXPECT_TRUE(take().empty()) << "nothing is told twice";
}

// Accepts everything and streams nothing.
class SilentCamera final : public CameraSource {
 public:
  explicit SilentCamera(Clock& clock) : clock_(clock) {
    mode_.card = "Silent";
    mode_.notes = {"asked for 30 frames a second, got 25"};
  }
  std::string description() const override { return "silent"; }
  Result<Frame> next(Instant deadline) override {
    clock_.sleep_until(deadline);
    return fail(FaultKind::timeout, "no frame");
  }
  const CameraMode& mode() const override { return mode_; }
  std::uint64_t frames_copied() const override { return 0; }

 private:
  Clock& clock_;
  CameraMode mode_;
};

TEST_F(Lines, ADayOfACameraThatStreamsNothingIsAHandfulOfLines) {
  FastForwardClock day{Utc{}};
  const auto before = spdlog::default_logger();
  spdlog::set_default_logger(std::make_shared<spdlog::logger>("day", sink));
  int opened = 0;
  const auto open = [&, log = ModeLog("scene camera")]() mutable {
    ++opened;
    return log(std::make_unique<SilentCamera>(day));
  };
  CameraLink camera({{"scene camera", open, {}}, Duration{0}, false}, day);
  for (const auto until = day.now() + 24h; day.now() < until;) static_cast<void>(camera.next(day.now() + 200ms));
  spdlog::set_default_logger(before);
  EXPECT_GT(opened, 4000);
  const auto lines = take();
  EXPECT_THAT(lines, testing::Contains(HasSubstr("Silent")));
  EXPECT_THAT(lines, testing::Contains(HasSubstr("not available yet: first frame")));
  EXPECT_LE(lines.size(), 4u) << testing::PrintToString(lines);
}

}  // namespace
}  // namespace kasumi
