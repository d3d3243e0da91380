#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "capture/fixture_writer.hpp"
#include "capture/replay_source.hpp"
#include "recording.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Writes frames 0, 1, 2, ... at the recorded instants; a negative instant is a disconnect at its amount.
std::filesystem::path record(const std::filesystem::path& folder, const std::vector<Duration>& instants) {
  std::filesystem::remove_all(folder);
  auto writer = FixtureWriter::create(folder).value();
  std::uint32_t sequence = 0;
  for (const auto instant : instants) {
    const auto written = instant < 0ns ? writer.append_disconnect(Instant{-instant}, Utc{-instant})
                                       : writer.append(frame_at(instant, sequence++));
    EXPECT_TRUE(written) << written.error().message;
  }
  return folder;
}

std::string outcome(const Result<Frame>& frame) {
  return frame ? fmt::format("{}", frame->metadata.sequence) : std::string(name_of(frame.error().kind));
}

class Replay : public testing::Test {
 protected:
  std::unique_ptr<ReplaySource> open(const std::vector<Duration>& instants, const ReplayOptions& options = {}) {
    auto source = open_replay(record(fresh_folder("replay"), instants), clock, options);
    EXPECT_TRUE(source) << source.error().message;
    return std::move(*source);
  }
  // What the source has to say right now.
  std::string poll(FrameSource& source) { return outcome(source.next(clock.now())); }

  ManualClock clock{Utc{}};
};

TEST_F(Replay, AFrameComesAtItsInstantAndNotANanosecondBefore) {
  const auto source = open({1000s, 1000s + 40ms, 1003s});
  EXPECT_EQ(poll(*source), "0");
  EXPECT_EQ(source->due(), Instant{40ms});
  clock.advance(40ms - 1ns);
  EXPECT_EQ(poll(*source), "timeout");
  clock.advance(1ns);
  EXPECT_EQ(poll(*source), "1");
  clock.advance(2s + 959ms);
  EXPECT_EQ(poll(*source), "timeout") << "a stall";
  clock.advance(1ms);
  EXPECT_EQ(poll(*source), "2");
  EXPECT_EQ(poll(*source), "end of stream");
  EXPECT_EQ(source->due(), std::nullopt);
}

TEST_F(Replay, TimeBetweenOpeningAndTheFirstQuestionIsNotPlayed) {
  const auto source = open({1000s, 1001s});
  clock.advance(1h);
  EXPECT_EQ(poll(*source), "0");
  EXPECT_EQ(poll(*source), "timeout");
  clock.advance(1s);
  EXPECT_EQ(poll(*source), "1");
}

TEST_F(Replay, AStartMayBeNamed) {
  const auto source = open({1000s, 1001s}, {.starts_at = Instant{10s}});
  EXPECT_EQ(poll(*source), "timeout");
  clock.advance(10s);
  EXPECT_EQ(poll(*source), "0");
}

TEST_F(Replay, LateFramesComeAtOnceAndNoneIsLost) {
  const auto source = open({0s, 1s, 2s, 3s});
  EXPECT_EQ(poll(*source), "0");
  clock.advance(10s);
  EXPECT_EQ(poll(*source), "1");
  EXPECT_EQ(poll(*source), "2");
  EXPECT_EQ(poll(*source), "3");
}

TEST_F(Replay, FramesWhoseTimestampsRunBackwardsComeAtOnceInTheOrderOfRows) {
  const auto source = open({10s, 12s, 11s, 5s, 13s});
  EXPECT_EQ(poll(*source), "0");
  clock.advance(2s);
  const auto second = source->next(clock.now());
  const auto third = source->next(clock.now());
  const auto fourth = source->next(clock.now());
  ASSERT_TRUE(second && third && fourth);
  EXPECT_EQ(second->metadata.sequence, 1u);
  EXPECT_EQ(third->metadata.sequence, 2u);
  EXPECT_EQ(fourth->metadata.sequence, 3u);
  EXPECT_EQ(fourth->metadata.captured_at, Instant{5s}) << "metadata is as recorded";
  EXPECT_EQ(poll(*source), "timeout");
  clock.advance(1s);
  EXPECT_EQ(poll(*source), "4");
}

TEST_F(Replay, ADisconnectLastsUntilTheNextRow) {
  const auto source = open({0s, -2s, 6s});
  EXPECT_EQ(poll(*source), "0");
  clock.advance(1s);
  EXPECT_EQ(poll(*source), "timeout") << "nothing says yet that it will go";
  clock.advance(1s);
  EXPECT_EQ(poll(*source), "disconnected");
  clock.advance(3s);
  EXPECT_EQ(poll(*source), "disconnected");
  clock.advance(1s);
  EXPECT_EQ(poll(*source), "1");
}

TEST_F(Replay, ADisconnectWakesAWaitingReaderAtOnce) {
  UnhurriedClock unhurried{Utc{}};
  const auto source = open_replay(record(fresh_folder("replay"), {0s, -2s, 6s}), unhurried).value();
  EXPECT_EQ(outcome(source->next(Instant{10s})), "0");
  EXPECT_EQ(outcome(source->next(Instant{10s})), "disconnected");
  EXPECT_EQ(unhurried.now(), Instant{2s});
  EXPECT_EQ(outcome(source->next(Instant{3s})), "disconnected") << "asking again takes time, so that time goes on";
  EXPECT_EQ(unhurried.now(), Instant{3s});
  EXPECT_EQ(outcome(source->next(Instant{10s})), "1");
  EXPECT_EQ(unhurried.now(), Instant{6s});
}

TEST_F(Replay, AFinalDisconnectIsToldOnceBeforeTheEnd) {
  const auto source = open({0s, -1s});
  EXPECT_EQ(poll(*source), "0");
  clock.advance(1s);
  EXPECT_EQ(poll(*source), "disconnected");
  EXPECT_EQ(poll(*source), "end of stream");
}

TEST_F(Replay, OnAnUnhurriedClockADayPassesWithoutWaiting) {
  UnhurriedClock unhurried{Utc{}};
  const auto source = open_replay(record(fresh_folder("replay"), {0s, 12h, 24h}), unhurried).value();
  EXPECT_EQ(outcome(source->next(Instant{24h})), "0");
  EXPECT_EQ(outcome(source->next(Instant{1h})), "timeout");
  EXPECT_EQ(unhurried.now(), Instant{1h});
  EXPECT_EQ(outcome(source->next(Instant{24h})), "1");
  EXPECT_EQ(outcome(source->next(Instant{24h})), "2");
  EXPECT_EQ(unhurried.now(), Instant{24h});
}

TEST_F(Replay, ABlockedReaderIsWokenByTheClockOrByAnInterrupt) {
  const auto source = open({0s, 5s, 10s});
  EXPECT_EQ(poll(*source), "0");
  std::vector<std::string> heard;
  std::thread reader([&] {
    heard.push_back(outcome(source->next(Instant{1h})));
    heard.push_back(outcome(source->next(Instant{1h})));
  });
  clock.advance(5s);
  clock.interrupt();
  reader.join();
  EXPECT_THAT(heard, ElementsAre("1", "timeout"));
}

TEST_F(Replay, RealTimeIsNeverEarly) {
  SystemClock real;
  const auto source = open_replay(record(fresh_folder("replay"), {500s, 500s + 30ms}), real).value();
  const auto before = real.now();
  EXPECT_EQ(outcome(source->next(before + 10s)), "0");
  EXPECT_EQ(outcome(source->next(before + 10s)), "1");
  EXPECT_GE(real.now() - before, 30ms);
}

TEST_F(Replay, ALoopRunsOnInTimeAndSequence) {
  const auto source = open({100s, 101s, 102s}, {.loop = true});
  std::vector<std::string> heard;
  for (int i = 0; i < 7; ++i, clock.advance(1s)) {
    const auto frame = source->next(clock.now());
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->metadata.captured_at, Instant{100s + i * 1s});
    EXPECT_EQ(frame->metadata.sequence, static_cast<std::uint32_t>(i));
    EXPECT_EQ(frame->metadata.utc, frame_at(100s + i % 3 * 1s, 0).metadata.utc) << "the sky shows the recorded sun";
    EXPECT_EQ(poll(*source), "timeout");
  }
}

TEST_F(Replay, ALoopOfOneFrameLetsTimePass) {
  const auto source = open({100s}, {.loop = true});
  EXPECT_EQ(poll(*source), "0");
  EXPECT_EQ(poll(*source), "timeout");
}

TEST_F(Replay, RowsOfOneFileShareItsBytes) {
  const auto source = open({0s, 0s, 0s});
  const auto first = source->next(clock.now()), second = source->next(clock.now());
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->payload.bytes.data(), second->payload.bytes.data());
}

TEST_F(Replay, DamagedRowsAreDeliveredWithTheirStatus) {
  const auto folder = folder_with_index("replay_damaged",
                                        "0,2026-06-21T03:00:00Z,0,YUYV,2,2,4,8,,,,a.yuyv\n"
                                        "1,2026-06-21T03:00:00Z,1,YUYV,2,2,4,8,,,error,a.yuyv\n"
                                        "2,2026-06-21T03:00:00Z,2,YUYV,2,2,4,7,,,,a.yuyv\n"
                                        "3,2026-06-21T03:00:00Z,3,YUYV,2,3,4,12,,,,a.yuyv\n"
                                        "4,2026-06-21T03:00:00Z,4,YUYV,2,2,4,0,,,,\n"
                                        "5,2026-06-21T03:00:00Z,5,MJPG,2,2,0,8,,,,a.yuyv\n"
                                        "6,2026-06-21T03:00:00Z,6,MJPG,2,2,0,9,,,,a.yuyv\n"
                                        "7,2026-06-21T03:00:00Z,7,MJPG,2,2,0,9,,,error,\n");
  UnhurriedClock unhurried{Utc{}};
  const auto source = open_replay(folder, unhurried).value();
  using enum FrameStatus;
  for (const auto& [status, bytes] : {std::pair{good, 8u},
                                      {flagged, 8u},
                                      {truncated, 7u},
                                      {truncated, 8u},
                                      {truncated, 0u},
                                      {good, 8u},
                                      {truncated, 8u},
                                      {flagged, 0u}}) {
    const auto frame = source->next(Instant{1s});
    ASSERT_TRUE(frame) << frame.error().message;
    EXPECT_EQ(frame->metadata.status, status) << "sequence " << frame->metadata.sequence;
    EXPECT_EQ(frame->payload.bytes.size(), bytes) << "sequence " << frame->metadata.sequence;
    const auto picture = decode(*frame, YuvEncoding::bt601_full);
    EXPECT_EQ(picture.has_value(), frame->metadata.sequence == 0) << "sequence " << frame->metadata.sequence;
  }
}

TEST_F(Replay, APayloadThatVanishesIsAnErrorAndTheRecordingGoesOn) {
  const auto source = open({0s, 0s});
  const auto folder = test_output_folder() / "capture" / "replay";
  std::filesystem::remove(folder / "frame-000000.yuyv");
  const auto lost = source->next(clock.now());
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().kind, FaultKind::io);
  EXPECT_THAT(lost.error().message, HasSubstr("frame-000000.yuyv"));
  ASSERT_TRUE(write_file(folder / "frame-000000.yuyv", std::vector<std::uint8_t>(96)));
  EXPECT_EQ(poll(*source), "1");
}

TEST_F(Replay, ARecordingWithoutAWholeRowIsRefused) {
  const auto source = open_replay(folder_with_index("replay_empty", "0,2026-06-2"), clock);
  ASSERT_FALSE(source);
  EXPECT_THAT(source.error().message, HasSubstr("expected at least one whole row"));
}

// ---- both cameras of a fixture -------------------------------------------------------------------------------------

std::filesystem::path fixture(const std::vector<Duration>& sky, const std::vector<Duration>& scene) {
  const auto folder = fresh_folder("fixture");
  record(folder / "sky", sky);
  record(folder / "scene", scene);
  return folder;
}

TEST_F(Replay, BothCamerasPlayOnOneTimeline) {
  const auto sources = open_fixture_sources(fixture({102s, 107s}, {100s, 101s, 102s}), clock);
  ASSERT_TRUE(sources) << sources.error().message;
  EXPECT_EQ(sources->sky->description(), "fixture fixture, sky camera");
  clock.advance(30s);
  EXPECT_EQ(poll(*sources->sky), "timeout") << "its first row is two seconds after the scene's";
  EXPECT_EQ(poll(*sources->scene), "0");
  clock.advance(2s);
  EXPECT_EQ(poll(*sources->sky), "0");
  EXPECT_EQ(poll(*sources->scene), "1");
  EXPECT_EQ(poll(*sources->scene), "2");
  EXPECT_EQ(sources->sky->due(), Instant{37s});
}

TEST_F(Replay, ALoopKeepsTheCamerasInStep) {
  const auto sources = open_fixture_sources(fixture({100s}, {100s, 104s}), clock, {.loop = true});
  ASSERT_TRUE(sources);
  for (int round = 0; round < 3; ++round) {  // 4 s and one interval of 4 s
    EXPECT_EQ(sources->sky->due(), Instant{round * 8s});
    EXPECT_EQ(sources->scene->due(), Instant{round * 8s});
    EXPECT_EQ(poll(*sources->sky), fmt::format("{}", round));
    EXPECT_EQ(poll(*sources->scene), fmt::format("{}", 2 * round));
    clock.advance(4s);
    EXPECT_EQ(poll(*sources->scene), fmt::format("{}", 2 * round + 1));
    clock.advance(4s);
  }
}

TEST_F(Replay, ProblemsOfBothCamerasAreToldAtOnce) {
  const auto folder = fresh_folder("fixture");
  const auto sources = open_fixture_sources(folder, clock);
  ASSERT_FALSE(sources);
  EXPECT_THAT(sources.error().message, HasSubstr("sky/index.csv"));
  EXPECT_THAT(sources.error().message, HasSubstr("scene/index.csv"));
}

std::vector<std::string> play_by_due(const std::filesystem::path& folder) {
  UnhurriedClock unhurried{Utc{}};
  const auto sources = open_fixture_sources(folder, unhurried).value();
  std::vector<std::string> order;
  for (;;) {
    const auto sky = sources.sky->due(), scene = sources.scene->due();
    if (!sky && !scene) return order;
    const bool sky_next = sky && (!scene || *sky <= *scene);
    auto& source = sky_next ? *sources.sky : *sources.scene;
    order.push_back((sky_next ? "sky " : "scene ") + outcome(source.next(*source.due())));
  }
}

TEST_F(Replay, OneThreadThatAsksByDuePlaysBothAlwaysInTheSameOrder) {
  const auto folder = fixture({0s, 5s, -6s, 10s}, {1s, 5s, 5500ms, 11s});
  EXPECT_THAT(play_by_due(folder),
              ElementsAre("sky 0", "scene 0", "sky 1", "scene 1", "scene 2", "sky disconnected", "sky 2", "scene 3"));
}

TEST_F(Replay, TwoThreadsOnOneUnhurriedClockEachGetEveryFrameInOrder) {
  std::vector<Duration> often, seldom;
  for (int i = 0; i < 200; ++i) often.push_back(i * 40ms);
  for (int i = 0; i < 20; ++i) seldom.push_back(i * 400ms);
  const auto folder = fixture(seldom, often);
  UnhurriedClock unhurried{Utc{}};
  const auto sources = open_fixture_sources(folder, unhurried).value();
  const auto drain = [&](FrameSource& source, std::vector<std::uint32_t>& seen) {
    for (;;) {
      const auto frame = source.next(unhurried.now() + 100ms);
      if (frame)
        seen.push_back(frame->metadata.sequence);
      else if (frame.error().kind == FaultKind::end_of_stream)
        return;
    }
  };
  std::vector<std::uint32_t> sky, scene;
  std::thread other([&] { drain(*sources.sky, sky); });
  drain(*sources.scene, scene);
  other.join();
  ASSERT_EQ(sky.size(), 20u);
  ASSERT_EQ(scene.size(), 200u);
  EXPECT_TRUE(std::ranges::is_sorted(sky));
  EXPECT_TRUE(std::ranges::is_sorted(scene));
}

}  // namespace
}  // namespace kasumi
