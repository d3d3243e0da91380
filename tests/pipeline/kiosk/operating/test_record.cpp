// Recording from live cameras: whatever is on the disk can be replayed, however it ended (rows 21 and 22 of the
// faults).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <thread>

#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include "gles/display/headless_display.hpp"
#include "pipeline/lab/recording/record.hpp"
#include "pipeline/lab/recording/record_screen.hpp"
#include "pipeline/lab/recording/recording.hpp"
#include "pipeline/lab/recording/replay.hpp"
#include "pipeline/site/config/fixture_file.hpp"
#include "pipeline/site/files/picture_sink.hpp"
#include "tests/must.hpp"
#include "tests/pipeline/kiosk/operating/kiosk.hpp"
#include "tests/places.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

Result<RecordSummary> record_kiosk(RecordRequest request) {
  SystemClock clock;
  const auto devices = machine_devices(clock);
  return record(request, *devices, clock, [] { return false; });
}

RecordRequest request_in(const std::filesystem::path& folder, const std::filesystem::path& config) {
  RecordRequest request;
  request.config = config;
  request.folder = folder / "kept";
  request.length = 1500ms;
  request.limits.keep_free = 0;
  return request;
}

// Plays a camera of the recording to its end; counts complete frames, outages, and truncated frames.
struct Played {
  int good = 0, cut = 0, outages = 0;
};
Played play(ReplaySource& source) {
  Played played;
  bool gone = false;
  for (;;) {
    const auto due = source.due();
    if (!due) return played;
    const auto frame = source.next(*due + 1s);
    if (!frame && frame.error().kind == FaultKind::end_of_stream) return played;
    const bool lost = !frame && frame.error().kind == FaultKind::disconnected;
    if (lost && !gone) ++played.outages;
    gone = lost;
    if (frame) ++(frame->metadata.status == FrameStatus::good ? played.good : played.cut);
  }
}

struct PlayedFixture {
  Played sky, scene;
};
Result<PlayedFixture> play(const std::filesystem::path& folder) {
  const auto fixture = read_fixture(folder);
  if (!fixture) return fail(fixture.error());
  FastForwardClock clock(fixture->info.start_utc);
  auto sources = open_fixture_sources(folder, clock);
  if (!sources) return fail(sources.error());
  return PlayedFixture{play(*sources->sky), play(*sources->scene)};
}

TEST(Record, ARecordingReplaysWithItsCalibration) {
  const auto folder = operating_folder("whole");
  const auto config = write_kiosk(folder);
  const auto summary = must(record_kiosk(request_in(folder, config)));
  EXPECT_TRUE(summary->whole) << summary->ended;
  EXPECT_THAT(summary->ended, HasSubstr("s recorded"));

  const auto played = must(play(folder / "kept"));
  EXPECT_EQ(played->sky.good, summary->sky.rows);
  EXPECT_EQ(played->scene.good, summary->scene.rows);
  EXPECT_GT(played->scene.good, 5) << "of 30 in 1.5 s, on a machine that may be slow";

  const auto live = ConfigTable::read_file(config);
  const auto was = read_run_config(*live).installation, is = read_fixture(folder / "kept")->installation;
  for (const glm::dvec2 pixel : {glm::dvec2(10.0, 12.0), glm::dvec2(40.25, 30.5)}) {
    EXPECT_EQ(was.sky.direction_at(pixel), is.sky.direction_at(pixel));
    EXPECT_EQ(was.scene.direction_at(pixel), is.scene.direction_at(pixel));
  }
  EXPECT_EQ(was.sky.mask.elements(), is.sky.mask.elements());
  EXPECT_EQ(was.object.placement.north_m, is.object.placement.north_m);

  // The bytes are the camera's: each payload equals one of those played.
  const auto rows = read_index(folder / "kept/scene").value();
  for (const auto& row : rows) {
    const auto kept = read_file(folder / "kept/scene" / row.payload).value();
    const auto sent = kiosk_frame(static_cast<int>(row.metadata.sequence % 60), 200);
    EXPECT_TRUE(std::equal(kept.begin(), kept.end(), sent.payload.bytes.begin(), sent.payload.bytes.end()));
  }

  ReplayRequest replay_request;
  replay_request.fixture = folder / "kept";
  replay_request.frames = 3;
  const auto replayed = must(replay(replay_request));
  EXPECT_EQ(replayed->pictures, 3u);
}

TEST(Record, AnOutageIsPartOfTheRecording) {
  const auto folder = operating_folder("outage");
  auto request = request_in(folder, write_kiosk(folder, 10));  // gone from 0.5 s to 1.5 s
  request.length = 4s;
  const auto summary = must(record_kiosk(request));
  const auto played = must(play(folder / "kept"));
  EXPECT_EQ(played->scene.outages, 1);
  EXPECT_EQ(played->sky.outages, 0);
  EXPECT_GT(played->scene.good, 10) << "frames from before and after";
}

// A frame every 2.2 s, slower than the two seconds after which a camera of video is taken for stalled.
TEST(Record, ASlowCameraIsNotTakenForLost) {
  const auto folder = operating_folder("slow");
  const auto config = write_kiosk(folder);
  for (const char* camera : {"sky", "scene"}) {
    std::filesystem::remove_all(folder / "live" / camera);
    auto writer = FixtureWriter::create(folder / "live" / camera).value();
    for (int i = 0; i < 10; ++i) ASSERT_TRUE(writer.append(kiosk_frame(44 * i, 90)));
  }
  auto request = request_in(folder, config);
  request.length = 6s;
  const auto summary = must(record_kiosk(request));
  for (const char* camera : {"sky", "scene"}) {
    const auto rows = read_index(folder / "kept" / camera).value();
    EXPECT_GE(rows.size(), 2u) << camera;
    for (const auto& row : rows) EXPECT_FALSE(row.disconnected) << camera;
  }
  EXPECT_EQ(summary->scene.health.opened, 1u);
}

TEST(Record, SaysWhatItIsARecordingOf) {
  const auto folder = operating_folder("provenance");
  auto request = request_in(folder, write_kiosk(folder));
  request.length = 300ms;
  ASSERT_TRUE(record_kiosk(request));
  const auto description = read_text_file(folder / "kept/fixture.toml").value();
  EXPECT_THAT(description, HasSubstr("Recorded by kasumi record from a recording ("));
  EXPECT_THAT(description, testing::Not(HasSubstr("live cameras")));
  RunConfig live;
  live.sky_camera = live.scene_camera = V4l2Options{};
  EXPECT_EQ(sources_text(live), "live cameras");
  live.sky_camera = ReplayCamera{"sky recording"};
  EXPECT_EQ(sources_text(live), "a recording (sky recording) (sky) and a live camera (scene)");
}

TEST(Record, FramesAreThinnedToTheInterval) {
  const auto folder = operating_folder("every");
  auto request = request_in(folder, write_kiosk(folder));
  request.every = 500ms;
  const auto summary = must(record_kiosk(request));
  EXPECT_GE(summary->scene.rows, 2);
  EXPECT_LE(summary->scene.rows, 4) << "at 0, 0.5, 1.0 and possibly 1.5 s";
}

TEST(Record, ItEndsBeforeItsBytesAreExceeded) {
  const auto folder = operating_folder("bytes");
  auto request = request_in(folder, write_kiosk(folder));
  request.limits.most_bytes = 10 * kKioskBytes + 5;
  request.length = 20s;
  const auto summary = must(record_kiosk(request));
  EXPECT_TRUE(summary->whole) << summary->ended;
  EXPECT_THAT(summary->ended, HasSubstr("MB recorded, the limit"));
  EXPECT_LT(summary->lasted, 15s);
  std::uintmax_t on_disk = 0;
  for (const char* camera : {"sky", "scene"})
    for (const auto& entry : std::filesystem::directory_iterator(folder / "kept" / camera))
      on_disk += entry.file_size();
  // The index has a header; both cameras may pass the limit at the same time.
  EXPECT_LE(on_disk, 11 * kKioskBytes + 2 * kIndexHeader.size() + 2000);
  EXPECT_TRUE(play(folder / "kept"));
}

TEST(Record, ItKeepsSpaceOnTheDiskFree) {
  const auto folder = operating_folder("floor");
  auto request = request_in(folder, write_kiosk(folder));
  request.limits.keep_free = std::uint64_t{1} << 60;
  const auto summary = must(record_kiosk(request));
  EXPECT_FALSE(summary->whole);
  EXPECT_THAT(summary->ended, HasSubstr("left on the disk, and"));
  EXPECT_EQ(summary->bytes, 0u);
}

TEST(Record, ARecordingIsNotOverwritten) {
  const auto folder = operating_folder("twice");
  auto request = request_in(folder, write_kiosk(folder));
  request.length = 300ms;
  ASSERT_TRUE(record_kiosk(request));
  EXPECT_THAT(record_kiosk(request), FailsAs(FaultKind::bad_input, HasSubstr("already contains a recording")));
}

// Visitors may be seen in it.
TEST(Record, NoOtherAccountReadsARecording) {
  const auto folder = operating_folder("closed");
  const auto config = write_kiosk(folder);
  std::filesystem::create_directories(folder / "open");
  std::filesystem::permissions(folder / "open", std::filesystem::perms(0777));
  for (const char* name : {"new", "open"}) {
    ASSERT_TRUE(Recording::create(config, folder / name, Utc{}, {}));
    EXPECT_EQ(std::filesystem::status(folder / name).permissions(), std::filesystem::perms(0700)) << name;
  }
}

// A separate file system, so that it can be filled.
class SmallDisk {
 public:
  explicit SmallDisk(const std::filesystem::path& at, const char* options) : at_(at) {
    std::filesystem::create_directories(at);
    mounted_ = ::mount("tmpfs", at.c_str(), "tmpfs", 0, options) == 0;
  }
  ~SmallDisk() {
    if (mounted_) ::umount2(at_.c_str(), MNT_DETACH);
  }
  bool mounted() const { return mounted_; }

 private:
  std::filesystem::path at_;
  bool mounted_ = false;
};

TEST(Record, AFullDiskEndsItAndTheRestReplays) {
  const auto folder = operating_folder("full");
  auto request = request_in(folder, write_kiosk(folder));
  const SmallDisk disk(folder / "disk", "size=800k");
  if (!disk.mounted()) GTEST_SKIP() << "only root may mount a small disk to fill";
  request.folder = folder / "disk/kept";
  request.length = 30s;
  const auto summary = must(record_kiosk(request));
  EXPECT_FALSE(summary->whole);
  EXPECT_LT(summary->lasted, 25s) << summary->ended;
  EXPECT_THAT(summary->ended, testing::AnyOf(HasSubstr("No space left"), HasSubstr("must stay free")));
  const auto played = must(play(request.folder));
  EXPECT_EQ(played->scene.good, summary->scene.rows);
  EXPECT_EQ(played->sky.good, summary->sky.rows);
  EXPECT_GT(played->scene.good, 5);
  EXPECT_EQ(played->scene.cut, 0);
  for (const auto& entry : std::filesystem::recursive_directory_iterator(request.folder))
    EXPECT_THAT(entry.path().filename().string(), testing::Not(HasSubstr(".part"))) << "left over";
}

// kill -9 simulates a power cut as far as the order of writes goes.
TEST(Record, KilledAtAnyMomentItReplays) {
  const auto folder = operating_folder("killed");
  const auto config = write_kiosk(folder);
  std::mt19937_64 random(22);
  int replayed = 0;
  for (int round = 0; round < 6; ++round) {
    const auto kept = folder / fmt::format("kept-{}", round);
    const auto child = ::fork();
    if (child == 0) {
      ::execl(kasumi_program().c_str(), "kasumi", "record", "--config", config.c_str(), "--out", kept.c_str(),
              "--seconds", "30", "--keep-free", "0", static_cast<char*>(nullptr));
      ::_exit(127);
    }
    ASSERT_GT(child, 0);
    // Not before there is something to replay: a row of each camera.
    const auto has_rows = [&](const char* camera) {
      const auto rows = read_index(kept / camera);
      return rows && !rows->empty();
    };
    for (int i = 0; i < 3000 && !(has_rows("sky") && has_rows("scene")); ++i) std::this_thread::sleep_for(10ms);
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 300'000));
    ASSERT_EQ(::kill(child, SIGKILL), 0);
    int how = 0;
    ::waitpid(child, &how, 0);
    ASSERT_TRUE(WIFSIGNALED(how)) << "it ended by itself, exit code " << WEXITSTATUS(how);
    const auto played = must(play(kept));
    EXPECT_EQ(played->scene.cut + played->sky.cut, 0) << "a row names a payload that is whole";
    replayed += played->scene.good;
  }
  EXPECT_GT(replayed, 6);
}

TEST(RecordScreen, ShowsThePictureAndTheNotice) {
  const auto folder = operating_folder("sign");
  const auto root = ConfigTable::read_file(write_kiosk(folder));
  const auto config = read_run_config(*root);
  SystemClock clock;
  auto headless = must(open_headless_display({320, 240}, clock));
  auto* seen = headless->get();
  auto screen = must(RecordScreen::open(std::move(*headless), config));
  const auto frame = kiosk_frame(0, 200);
  ASSERT_TRUE(screen->show(&frame, "Recording\n00:42   12 MB", clock.now() + 1s));
  const auto picture = must(seen->read());
  ASSERT_TRUE(write_png(folder / "seen.png", *picture));

  int red = 0;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 60; ++x) {
      const auto c = picture->at(x, y);
      red += c.r > 180 && c.g < 80 && c.b < 80;
    }
  EXPECT_GT(red, 80) << "pixels of the red light, about 14 across";
  // Elsewhere the camera's own picture: values of 100 to 163 as kiosk_frame paints them.
  const auto c = picture->at(250, 200);
  EXPECT_THAT(int{c.r}, testing::AllOf(testing::Ge(98), testing::Le(165)));
  ASSERT_TRUE(screen->show(nullptr, "Recording\n00:43   12 MB", clock.now() + 1s)) << "and again without a new one";
  EXPECT_EQ(seen->read()->at(250, 200), c);
}

}  // namespace
}  // namespace kasumi
