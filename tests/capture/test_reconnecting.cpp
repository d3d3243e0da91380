// Rows 1 and 3 to 11 of docs/faults.md: a fake camera behind the boundary of system calls, a reader that draws at 50 Hz
// and holds the last frame, and the recovery time by the clock.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <iostream>
#include <thread>

#include "capture/fixture/fixture_writer.hpp"
#include "capture/fixture/replay_source.hpp"
#include "capture/reconnecting_source.hpp"
#include "tests/capture/known_frames.hpp"
#include "tests/capture/v4l2/fake_camera.hpp"

namespace kasumi {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::Ge;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Le;
using testing::Pair;

const FakeMode kNv12{V4L2_PIX_FMT_NV12, 64, 48};

class Faults : public testing::Test {
 protected:
  Faults() { watch(opener(camera)); }

  V4l2Options options() const {
    V4l2Options options{"/dev/v4l/by-id/fake", {}};
    options.request.width = 64;
    options.request.height = 48;
    return options;
  }
  SourceOpener opener(FakeCamera& from) {
    return {"scene camera",
            [this, &from]() -> Result<std::unique_ptr<FrameSource>> {
              opened_at.push_back(clock.now());
              if (!from.plugged_in()) return fail(FaultKind::disconnected, "no such device now");
              auto opened = open_v4l2_source(from.open(), options(), clock);
              if (!opened) return fail(opened.error());
              return std::move(*opened);
            },
            [&from] { return from.plugged_in(); }};
  }
  void watch(SourceOpener opener, const ReconnectTimes& with = {}) {
    held = Frame{};
    source = reconnecting(std::move(opener), clock, with);
  }

  // One picture interval of the reader. True when a good frame arrived.
  bool step() {
    const auto deadline = clock.now() + 20ms;
    auto frame = source->next(deadline);
    if (frame) {
      if (frame->metadata.status != FrameStatus::good) return false;
      held = std::move(*frame);
      return true;
    }
    if (frame.error().kind == FaultKind::disconnected) {
      held = Frame{};
      ++disconnects;
      last_message = frame.error().message;
    } else {
      EXPECT_EQ(frame.error().kind, FaultKind::timeout) << frame.error().message;
      EXPECT_LE(clock.now(), deadline);
    }
    return false;
  }
  void run(Duration time) {
    for (const auto until = clock.now() + time; clock.now() < until;) step();
  }
  // Time until a good frame arrives; an hour at most.
  Duration until_good() {
    const auto from = clock.now();
    while (!step())
      if (clock.now() - from > 1h) return Duration::max();
    return clock.now() - from;
  }
  // Time until the reader is asked to release its frames.
  Duration until_disconnected() {
    const auto from = clock.now();
    for (const int before = disconnects; disconnects == before;) {
      step();
      if (clock.now() - from > 1h) return Duration::max();
    }
    return clock.now() - from;
  }
  static void print(int row, std::string_view what, Duration time, Duration allowed) {
    std::cout << fmt::format("row {:2}: {}: {:.2f} s (allowed {:.3g})\n", row, what, to_seconds(time),
                             to_seconds(allowed));
    EXPECT_LE(time, allowed) << what;
  }
  void expect_nothing_held() {
    EXPECT_EQ(camera.opened(), 0);
    EXPECT_EQ(camera.mapped(), 0);
    EXPECT_FALSE(camera.allocated());
  }

  FastForwardClock clock{Utc{std::chrono::sys_days{std::chrono::June / 21 / 2026}}};
  FakeCamera camera{{kNv12}, clock};
  std::unique_ptr<ReconnectingSource> source;
  Frame held;  // as a display holds the frame it shows
  int disconnects = 0;
  std::string last_message;
  std::vector<Instant> opened_at;
};

TEST_F(Faults, AWorkingCamerasFramesPassUnchanged) {
  run(10s);
  const auto health = source->health();
  EXPECT_TRUE(health.up);
  EXPECT_EQ(health.good_frames, 250u);
  EXPECT_EQ(health.opened, 1u);
  EXPECT_THAT(health.reopened, IsEmpty());
  EXPECT_THAT(health.bad_frames, IsEmpty());
  EXPECT_EQ(health.sequence_gaps + health.backwards + health.mode_changes + health.skipped, 0u);
  EXPECT_EQ(health.condition, PictureCondition::normal);
  ASSERT_TRUE(health.mode);
  EXPECT_EQ(health.mode->card, "Fake Camera");
  EXPECT_EQ(disconnects, 0);
}

TEST_F(Faults, Row1AReplugIsNoticedHoweverLongItTook) {
  run(5s);
  for (const auto away : {Duration{300ms}, Duration{3s}, Duration{60s}, Duration{20min}}) {
    camera.unplug();
    EXPECT_LE(until_disconnected(), 40ms);
    EXPECT_THAT(last_message, HasSubstr("unplugged"));
    expect_nothing_held();
    run(away);
    EXPECT_FALSE(source->health().up);
    EXPECT_EQ(source->health().cause, "unplugged");
    camera.plug_in();
    const auto time = until_good();
    print(1, fmt::format("frames after a replug that came after {:.1f} s", to_seconds(away)), time, 3s);
    run(5s);
    EXPECT_TRUE(source->health().up);
    EXPECT_EQ(source->health().cause, "");
    EXPECT_GE(source->health().last_outage, away);
  }
  EXPECT_EQ(disconnects, 4) << "once for each";
  EXPECT_THAT(source->health().reopened, ElementsAre(Pair("unplugged", 4)));
}

TEST_F(Faults, Row1WithoutPresenceDetectionTheLongestBackoffBoundsTheDelay) {
  auto blind = opener(camera);
  blind.present = nullptr;
  watch(blind);
  run(5s);
  camera.unplug();
  run(10min);
  camera.plug_in();
  print(1, "frames after an unannounced replug", until_good(), 19s);
}

TEST_F(Faults, Row3TheStablePathIsFollowedWhenNumbersSwap) {
  const auto devices = fresh_folder("swapped");
  FakeCamera other({kNv12}, clock);
  const auto grey_of = [](int grey) {
    return [grey](std::uint32_t) {
      return std::vector<std::vector<std::uint8_t>>{
          std::vector<std::uint8_t>(64 * 48 * 3 / 2, static_cast<std::uint8_t>(grey))};
    };
  };
  camera.content = grey_of(50);
  other.content = grey_of(200);
  std::map<std::string, FakeCamera*> numbers;
  const auto plug = [&](FakeCamera& scene_camera, const char* scene, FakeCamera& sky_camera, const char* sky) {
    numbers = {{scene, &scene_camera}, {sky, &sky_camera}};
    std::filesystem::create_symlink(scene, devices / "by-id-scene");
    std::filesystem::create_symlink(sky, devices / "by-id-sky");
    scene_camera.plug_in();
    sky_camera.plug_in();
  };
  const auto unplug = [&](FakeCamera& scene_camera, FakeCamera& sky_camera) {
    scene_camera.unplug();
    sky_camera.unplug();
    std::filesystem::remove(devices / "by-id-scene");
    std::filesystem::remove(devices / "by-id-sky");
  };
  SourceOpener by_link;
  by_link.name = "scene camera";
  by_link.present = [&] { return std::filesystem::is_symlink(devices / "by-id-scene"); };
  by_link.open = [&]() -> Result<std::unique_ptr<FrameSource>> {
    std::error_code error;
    const auto node = std::filesystem::read_symlink(devices / "by-id-scene", error);
    if (error) return fail(FaultKind::disconnected, "no such device now");
    auto opened = open_v4l2_source(numbers.at(node.string())->open(), options(), clock);
    if (!opened) return fail(opened.error());
    return std::move(*opened);
  };
  plug(camera, "video0", other, "video2");
  watch(by_link);
  run(1s);
  EXPECT_EQ(held.payload.bytes.front(), 50);
  unplug(camera, other);
  run(5s);
  plug(camera, "video2", other, "video0");
  print(3, "the same camera under another number", until_good(), 3s);
  EXPECT_EQ(held.payload.bytes.front(), 50) << "the scene, not the sky";
}

TEST_F(Faults, Row4ARefusedCallWorksAtTheNextAttempt) {
  for (const auto& [call, name] :
       {std::pair{VIDIOC_REQBUFS, "VIDIOC_REQBUFS"}, std::pair{VIDIOC_QBUF, "VIDIOC_QBUF"},
        std::pair{VIDIOC_STREAMON, "VIDIOC_STREAMON"}, std::pair{VIDIOC_S_FMT, "VIDIOC_S_FMT"}}) {
    watch(opener(camera));
    camera.refuse(call, EIO, 1);
    EXPECT_LE(until_disconnected(), 20ms);
    EXPECT_THAT(source->health().cause, HasSubstr(name));
    expect_nothing_held();
    print(4, fmt::format("frames after {} failed once", name), until_good(), 2s);
  }
}

TEST_F(Faults, Row5AStreamThatNeverDeliversIsReopened) {
  camera.stop_filling(true);
  const auto noticed = until_disconnected();
  print(5, "no first frame noticed", noticed, 4020ms);
  EXPECT_GE(noticed, 4s);
  EXPECT_EQ(source->health().cause, "first frame: none for 4.0 s");
  expect_nothing_held();
  camera.stop_filling(false);
  print(5, "frames after the driver delivers again", until_good(), 2s);
  EXPECT_THAT(source->health().reopened, ElementsAre(Pair("first frame", 1)));
}

TEST_F(Faults, Row6AStallIsDetectedAndEndedByReopening) {
  run(10s);
  const auto last = *source->health().last_good;
  camera.stop_filling(true);
  until_disconnected();
  const auto noticed = clock.now() - last;
  print(6, "stall noticed after the last frame", noticed, 2100ms);
  EXPECT_GE(noticed, 2s);
  EXPECT_EQ(source->health().cause, "stalled: no frame for 2.0 s");
  camera.stop_filling(false);
  until_good();
  print(6, "frames after the last one before the stall", clock.now() - last, 5s);
  EXPECT_THAT(source->health().reopened, ElementsAre(Pair("stall", 1)));
}

TEST_F(Faults, Row7AFatalErrorOfTheQueueIsOverSoon) {
  run(10s);
  for (int i = 0; i < 3; ++i) {
    camera.fail_queue();
    print(7, "frames after a fatal error of the queue", until_good(), 2s);
    run(5s);
  }
  EXPECT_EQ(disconnects, 3);
  EXPECT_THAT(last_message, HasSubstr("Input/output error"));
  EXPECT_THAT(source->health().reopened, ElementsAre(Pair("fatal", 3)));
}

TEST_F(Faults, Row8BadFramesAreCountedByReasonAndTheNextGoodOneIsShown) {
  run(2s);
  camera.tamper([](FakeAnswer& answer) {
    if (answer.number % 5 == 1) answer.buffer.flags |= V4L2_BUF_FLAG_ERROR;
    if (answer.number % 5 == 2) answer.planes[0].bytesused = 0;
    if (answer.number % 5 == 3) answer.planes[0].bytesused = 100;
  });
  auto longest = Duration::zero();
  for (int i = 0; i < 40; ++i) longest = std::max(longest, until_good());
  print(8, "longest time between good frames, three of five bad", longest, 160ms);
  const auto health = source->health();
  EXPECT_GE(health.bad_frames.at("flagged"), 18u);
  EXPECT_NEAR(static_cast<double>(health.bad_frames.at("truncated")),
              2.0 * static_cast<double>(health.bad_frames.at("flagged")), 2.0);
  EXPECT_EQ(health.opened, 1u);
  EXPECT_TRUE(health.up);
}

TEST_F(Faults, Row8AFrameTheReaderRejectsCountsAsBad) {
  run(2s);
  const auto before = source->health();
  until_good();
  source->reject("damaged JPEG");
  source->reject("damaged JPEG");  // reported twice, counted once
  const auto after = source->health();
  EXPECT_EQ(after.good_frames, before.good_frames);
  EXPECT_EQ(after.last_good, before.last_good);
  EXPECT_THAT(after.bad_frames, ElementsAre(Pair("damaged JPEG", 1)));
}

TEST_F(Faults, Row9ACameraThatDeliversOnlyBadFramesIsReopened) {
  run(10s);
  for (const bool rejected : {false, true}) {
    const auto from = clock.now();
    if (!rejected) camera.tamper([](FakeAnswer& answer) { answer.buffer.flags |= V4L2_BUF_FLAG_ERROR; });
    for (const int before = disconnects; disconnects == before;) {
      if (step() && rejected) source->reject("damaged JPEG");
      ASSERT_LT(clock.now() - from, 1min);
    }
    EXPECT_GE(clock.now() - from, 10s);
    EXPECT_THAT(last_message, HasSubstr("no good frame for 10."));
    camera.tamper({});
    until_good();
    print(9, rejected ? "good frames after rejected ones" : "good frames after flagged ones", clock.now() - from, 15s);
    run(10s);
  }
  EXPECT_THAT(source->health().reopened, ElementsAre(Pair("bad frames", 2)));
}

TEST_F(Faults, Row10AnotherFormatOnReturnIsNoticedAndPassedOn) {
  FakeCamera yuyv({{V4L2_PIX_FMT_YUYV, 64, 48}}, clock);
  FakeCamera* now = &camera;
  SourceOpener changing{"scene camera",
                        [&]() -> Result<std::unique_ptr<FrameSource>> {
                          auto opened = open_v4l2_source(now->open(), options(), clock);
                          if (!opened) return fail(opened.error());
                          return std::move(*opened);
                        },
                        {}};
  watch(changing);
  run(1s);
  EXPECT_EQ(held.metadata.format, four_cc("NV12"));
  camera.unplug();
  now = &yuyv;
  print(10, "frames in another format", until_good(), 2s);
  EXPECT_EQ(held.metadata.format, four_cc("YUYV"));
  EXPECT_TRUE(decode(held, YuvEncoding::bt601_full));
  EXPECT_EQ(source->health().mode_changes, 1u);
  EXPECT_EQ(source->health().mode->format, four_cc("YUYV"));
  held = Frame{};
  source.reset();
}

TEST_F(Faults, Row11TimestampsThatRunBackwardsAndGapsAreCountedAndNothingElse) {
  run(1s);
  const auto good = source->health().good_frames;
  camera.tamper([](FakeAnswer& answer) {
    answer.buffer.sequence = answer.number * 3;                   // two lost each time
    if (answer.number == 50) answer.buffer.timestamp.tv_sec = 0;  // back once
    if (answer.number >= 60) answer.buffer.timestamp.tv_sec -= 100;
  });
  auto longest = Duration::zero();
  for (int i = 0; i < 100; ++i) longest = std::max(longest, until_good());
  print(11, "longest time between frames whose times and counters jump", longest, 60ms);
  const auto health = source->health();
  EXPECT_EQ(health.good_frames, good + 100);
  EXPECT_EQ(health.backwards, 2u);
  EXPECT_GE(health.sequence_gaps, 2u * 99);
  EXPECT_EQ(health.opened, 1u);
}

TEST_F(Faults, Row11ACounterThatWrapsIsNotAGap) {
  camera.tamper([](FakeAnswer& answer) { answer.buffer.sequence = answer.number + 0xffffffe0u; });
  run(4s);
  EXPECT_EQ(source->health().sequence_gaps, 0u);
  EXPECT_EQ(source->health().good_frames, 100u);
}

TEST_F(Faults, FramesSkippedByALateReaderAreNotGaps) {
  run(1s);
  clock.sleep_until(clock.now() + 170ms);
  run(1s);
  EXPECT_EQ(source->health().sequence_gaps, 0u);
  EXPECT_EQ(source->health().skipped, 3u);
}

TEST_F(Faults, APausedReaderIsNotAStall) {
  run(1s);
  for (const auto pause : {Duration{3s}, Duration{1min}}) {
    clock.sleep_until(clock.now() + pause);
    EXPECT_LE(until_good(), 40ms);
  }
  EXPECT_EQ(source->health().opened, 1u);
  EXPECT_EQ(disconnects, 0);
}

// --- waiting

TEST_F(Faults, WaitsGrowFromOneSecondToFifteenWithJitter) {
  auto blind = opener(camera);
  blind.present = nullptr;
  camera.unplug();
  std::map<std::uint64_t, std::vector<double>> waits;
  for (const std::uint64_t seed : {1u, 2u}) {
    opened_at.clear();
    watch(blind, {.seed = seed});
    run(5min);
    for (std::size_t i = 1; i < opened_at.size(); ++i)
      waits[seed].push_back(to_seconds(opened_at[i] - opened_at[i - 1]));
    ASSERT_GE(waits[seed].size(), 15u);
    for (std::size_t i = 0; i < waits[seed].size(); ++i) {
      const double nominal = i < 4 ? std::exp2(static_cast<double>(i)) : 15.0;
      EXPECT_THAT(waits[seed][i], AllOf(Ge(0.8 * nominal - 0.001), Le(1.2 * nominal + 0.001))) << i;
    }
  }
  EXPECT_NE(waits[1], waits[2]) << "two cameras on one bus do not retry at the same time";
}

TEST_F(Faults, ACameraThatFailsAtOnceEachTimeIsRetriedLessAndLessOften) {
  const auto gap = [&] { return to_seconds(opened_at.back() - opened_at[opened_at.size() - 2]); };
  for (const double nominal : {1.0, 2.0, 4.0, 8.0, 15.0, 15.0}) {
    until_good();
    camera.fail_queue();
    until_disconnected();
    until_good();
    EXPECT_NEAR(gap(), nominal, 0.2 * nominal + 0.1);
  }
  run(20s);
  camera.fail_queue();
  const auto time = until_good();
  EXPECT_LE(time, 1300ms) << "it had stayed up, so the backoff starts over";
}

// A device that has just been plugged in is often not ready at once: waiting as long as for an absent one would break
// the promise of three seconds.
TEST_F(Faults, Row1AReplugBeginsTheWaitsAnew) {
  run(5s);
  for (const auto seed : {1u, 2u, 3u}) {
    int not_ready = 0;
    auto ready = opener(camera);
    auto slow = ready;
    slow.open = [&, ready]() -> Result<std::unique_ptr<FrameSource>> {
      if (camera.plugged_in() && not_ready-- > 0) return fail(FaultKind::device, "device or resource busy");
      return ready.open();
    };
    watch(slow, {.seed = seed});
    run(5s);
    camera.unplug();
    run(5min);
    not_ready = 1;
    camera.plug_in();
    print(1, "replugged, and busy at first", until_good(), 3s);
  }
}

TEST_F(Faults, ACameraMissingAtTheStartIsReportedOnceAndAwaited) {
  camera.unplug();
  run(1min);
  EXPECT_EQ(disconnects, 1);
  EXPECT_THAT(last_message, HasSubstr("unplugged"));
  EXPECT_EQ(source->health().opened, 0u);
  camera.plug_in();
  EXPECT_LE(until_good(), 300ms);
  EXPECT_THAT(source->health().reopened, IsEmpty());
}

TEST_F(Faults, AReaderHoldingFramesOnAnOldKernelDelaysReopeningOnlyWhileItHoldsThem) {
  camera.keeps_orphans = false;
  run(2s);
  const Frame kept = held;
  camera.fail_queue();
  run(10s);
  EXPECT_FALSE(source->health().up);
  EXPECT_THAT(source->health().cause, HasSubstr("in use"));
  const_cast<Frame&>(kept) = Frame{};
  EXPECT_LE(until_good(), 18s);
}

TEST_F(Faults, NothingIsOpenedBeforeTheFirstRead) {
  clock.sleep_until(clock.now() + 10s);
  EXPECT_THAT(opened_at, IsEmpty());
  step();
  EXPECT_EQ(opened_at.size(), 1u);
}

TEST_F(Faults, AnInterruptedClockEndsTheWaitForACamera) {
  ManualClock manual{Utc{}};
  const auto waiting = reconnecting(
      {"camera", []() -> Result<std::unique_ptr<FrameSource>> { return fail(FaultKind::disconnected, "gone"); }, {}},
      manual);
  EXPECT_EQ(waiting->next(manual.now()).error().kind, FaultKind::disconnected);
  std::thread other([&] { manual.interrupt(); });
  EXPECT_EQ(waiting->next(manual.now() + 1h).error().kind, FaultKind::timeout);
  other.join();
}

TEST_F(Faults, HealthCanBeReadFromAnotherThread) {
  std::atomic<bool> ended{false};
  std::uint64_t seen = 0;
  std::thread other([&] {
    while (!ended) {
      const auto health = source->health();
      EXPECT_GE(health.good_frames, seen);
      seen = health.good_frames;
    }
  });
  for (int i = 0; i < 10; ++i) {
    run(1s);
    camera.fail_queue();
    run(2s);
  }
  ended = true;
  other.join();
}

// --- recordings

TEST(Reopening, ARecordingPlaysOnDuringAnOutageAndResumesAtTheRightTime) {
  const auto folder = fresh_folder("reopening");
  {
    auto writer = FixtureWriter::create(folder).value();
    for (std::uint32_t i = 0; i < 250; ++i) {
      const auto at = 40ms * i;
      if (i == 50) {
        EXPECT_TRUE(writer.append_disconnect(Instant{at}, Utc{at}));
      }
      if (i < 50 || i > 150) {
        EXPECT_TRUE(writer.append(frame_at(at, i)));
      }
    }
  }
  FastForwardClock clock{Utc{}};
  const auto source = reconnecting(reopening("sky camera", open_replay(folder, clock).value(), clock), clock);
  std::vector<std::uint32_t> sequences;
  int disconnects = 0;
  while (true) {
    const auto frame = source->next(clock.now() + 20ms);
    if (frame) sequences.push_back(frame->metadata.sequence);
    if (frame) continue;
    if (frame.error().kind == FaultKind::end_of_stream) break;
    disconnects += frame.error().kind == FaultKind::disconnected;
  }
  EXPECT_EQ(disconnects, 1);
  EXPECT_EQ(sequences.size(), 149u) << "no frame is lost";
  EXPECT_EQ(sequences.back(), 249u);
  EXPECT_LE(source->health().last_outage, 4040ms + 250ms);
  EXPECT_THAT(source->health().reopened, ElementsAre(Pair("unplugged", 1)));
}

}  // namespace
}  // namespace kasumi
