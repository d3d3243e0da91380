// A camera through V4L2: the one KASUMI_V4L2_DEVICE names; skipped without. If it is vivid, its error injection is
// tested as well. KASUMI_V4L2_SIZE: "640x360" when left out.
#include <gtest/gtest.h>

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>

#include <cstdlib>
#include <cstring>
#include <iostream>

#include "base/unique_fd.hpp"
#include "capture/reconnecting_source.hpp"
#include "capture/v4l2/formats.hpp"
#include "capture/v4l2/v4l2_source.hpp"
#include "capture/v4l2/video_device.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

// A real device of which only the formats with several memory planes are visible.
class SeveralPlanesOnly final : public VideoDevice {
 public:
  explicit SeveralPlanesOnly(std::unique_ptr<VideoDevice> device) : device_(std::move(device)) {}
  int control(unsigned long request, void* argument) override {
    if (request != VIDIOC_ENUM_FMT) return device_->control(request, argument);
    auto& entry = *static_cast<v4l2_fmtdesc*>(argument);
    for (std::uint32_t index = 0, left = entry.index; index < 256; ++index) {
      auto real = entry;
      real.index = index;
      if (const int error = device_->control(request, &real); error != 0) return error;
      const auto* format = find_v4l2_format(real.pixelformat);
      if (!format || format->planes < 2 || left-- != 0) continue;
      entry.pixelformat = real.pixelformat;
      return 0;
    }
    return EINVAL;
  }
  VideoEvents wait(Duration longest) override { return device_->wait(longest); }
  std::span<const std::uint8_t> map(std::size_t length, std::int64_t offset, int& error) override {
    return device_->map(length, offset, error);
  }
  void unmap(std::span<const std::uint8_t> mapped) override { device_->unmap(mapped); }

 private:
  std::unique_ptr<VideoDevice> device_;
};

class V4l2Live : public testing::Test {
 protected:
  void SetUp() override {
    const char* device = std::getenv("KASUMI_V4L2_DEVICE");
    if (!device) GTEST_SKIP() << "KASUMI_V4L2_DEVICE names no camera";
    options_.device = device;
    const char* size = std::getenv("KASUMI_V4L2_SIZE");
    ASSERT_EQ(std::sscanf(size ? size : "640x360", "%dx%d", &options_.request.width, &options_.request.height), 2);
  }
  std::unique_ptr<CameraSource> open() {
    auto source = open_v4l2_source(options_, clock_);
    EXPECT_TRUE(source) << source.error().message;
    return source ? std::move(*source) : nullptr;
  }
  static int open_descriptors() {
    int count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
    return count;
  }

  SystemClock clock_;
  V4l2Options options_;
};

TEST_F(V4l2Live, IsListedWithItsFormats) {
  const auto listings = list_v4l2_cameras();
  bool found = false;
  for (const auto& listing : listings) {
    std::cout << fmt::format("{}: {} ({}) at {} {}\n", listing.node.string(), listing.card, listing.driver,
                             listing.place, listing.problem);
    for (const auto& path : listing.stable_paths) std::cout << "  " << path.string() << "\n";
    for (const auto& format : listing.formats) std::cout << "  " << format.substr(0, 160) << "\n";
    found = found || std::filesystem::canonical(listing.node) == std::filesystem::canonical(options_.device);
  }
  EXPECT_TRUE(found);
}

TEST_F(V4l2Live, FramesAreCompleteFreshAndDecodable) {
  const auto source = open();
  ASSERT_TRUE(source);
  const auto& mode = source->mode();
  std::cout << fmt::format("{} {}x{} stride {}, {:.4g} /s, {}\n", mode.format.text(), mode.width, mode.height,
                           mode.stride, mode.frames_per_second,
                           mode.yuv_encoding ? name_of(*mode.yuv_encoding) : "no YUV");
  for (const auto& note : mode.notes) std::cout << "  " << note << "\n";
  std::optional<FrameMetadata> last;
  for (int i = 0; i < 30; ++i) {
    const auto frame = source->next(clock_.now() + 4s);
    ASSERT_TRUE(frame) << frame.error().message;
    ASSERT_EQ(frame->metadata.status, FrameStatus::good);
    const auto picture = decode(*frame, YuvEncoding::bt601_full);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_LT(std::chrono::abs(clock_.now() - frame->metadata.captured_at), 2s);
    if (last) {
      // v4l2loopback passes on its writer's sequence numbers, which may all be 0.
      EXPECT_TRUE(frame->metadata.sequence > last->sequence || frame->metadata.sequence == 0);
      EXPECT_GT(frame->metadata.captured_at, last->captured_at);
    }
    last = frame->metadata;
  }
  EXPECT_EQ(source->frames_copied(), mode.driver == "v4l2 loopback" ? 30u : 0u);
}

TEST_F(V4l2Live, EveryOfferedFormatWeReadStreams) {
  for (const char* format : {"YUYV", "UYVY", "NV12", "YU12", "RGB3", "BGR3", "XR24", "AB24", "GREY", "MJPG"}) {
    options_.request.format = parse_four_cc(format).value();
    const auto source = open_v4l2_source(options_, clock_);
    if (!source) {
      EXPECT_EQ(source.error().kind, FaultKind::bad_input) << source.error().message;
      std::cout << format << ": not offered\n";
      continue;
    }
    const auto frame = (*source)->next(clock_.now() + 4s);
    ASSERT_TRUE(frame) << format << ": " << frame.error().message;
    ASSERT_EQ(frame->metadata.status, FrameStatus::good) << format;
    ASSERT_TRUE(decode(*frame, YuvEncoding::bt601_full)) << format;
    std::cout << fmt::format("{}: {} bytes, stride {}, {}{}\n", format, frame->metadata.bytes_used,
                             frame->metadata.stride, frame->payload.dma_buf ? "dma-buf" : "no dma-buf",
                             (*source)->frames_copied() == 0 ? "" : ", copied");
  }
}

TEST_F(V4l2Live, PlanesInSeparateMemoriesGiveTheSamePictureAsInOne) {
  // vivid's picture is static except for a counter: most of it must be the same either way.
  for (const char* format : {"NV12", "YU12"}) {
    options_.request.format = parse_four_cc(format).value();
    auto device = open_video_device(options_.device);
    ASSERT_TRUE(device) << device.error().message;
    auto source = open_v4l2_source(std::make_unique<SeveralPlanesOnly>(std::move(*device)), options_, clock_);
    if (!source) GTEST_SKIP() << "offers no format with several memory planes: " << source.error().message;
    const auto gathered = (*source)->next(clock_.now() + 4s);
    ASSERT_TRUE(gathered) << gathered.error().message;
    ASSERT_EQ(gathered->metadata.status, FrameStatus::good);
    EXPECT_EQ((*source)->frames_copied(), 1u);
    source->reset();
    const auto plain = open();
    ASSERT_TRUE(plain);
    const auto lent = plain->next(clock_.now() + 4s);
    ASSERT_TRUE(lent) << lent.error().message;
    const auto a = to_rgb(decode(*gathered, YuvEncoding::bt601_limited).value().view()).elements();
    const auto b = to_rgb(decode(*lent, YuvEncoding::bt601_limited).value().view()).elements();
    ASSERT_EQ(a.size(), b.size());
    std::size_t same = 0;
    for (std::size_t i = 0; i < a.size(); ++i) same += a[i] == b[i];
    std::cout << fmt::format("{}: {:.1f} % of the pixels are the same\n", format,
                             100.0 * static_cast<double>(same) / static_cast<double>(a.size()));
    EXPECT_GT(same, a.size() * 9 / 10);
  }
}

TEST_F(V4l2Live, GainIsSetLockedAndReadBackWhereAvailable) {
  options_.request.gain = 100.0;
  const auto source = open();
  ASSERT_TRUE(source);
  for (const auto& note : source->mode().notes) std::cout << "  " << note << "\n";
  if (!source->mode().gain) GTEST_SKIP() << "it has no gain";
  EXPECT_EQ(source->mode().gain, 100.0);
}

TEST_F(V4l2Live, HoldingFramesDoesNotStarveIt) {
  const auto source = open();
  ASSERT_TRUE(source);
  std::vector<Frame> held;
  for (int i = 0; i < 12; ++i) {
    auto frame = source->next(clock_.now() + 4s);
    ASSERT_TRUE(frame) << i << ": " << frame.error().message;
    held.push_back(std::move(*frame));
  }
  EXPECT_GE(source->frames_copied(), 4u);
}

TEST_F(V4l2Live, ReopensWhileFramesAreHeldAndLeavesNothingBehind) {
  const int before = open_descriptors();
  for (int i = 0; i < 5; ++i) {
    auto source = open();
    ASSERT_TRUE(source);
    auto held = source->next(clock_.now() + 4s);
    ASSERT_TRUE(held) << held.error().message;
    source.reset();
    const auto again = open();
    ASSERT_TRUE(again);
    ASSERT_TRUE(again->next(clock_.now() + 4s));
    const auto first = held->payload.bytes.front();  // still mapped
    EXPECT_EQ(first, held->payload.bytes.front());
  }
  EXPECT_EQ(open_descriptors(), before);
}

// vivid's own controls, by name, through a second descriptor, as v4l2-ctl uses.
class VividLive : public V4l2Live {
 protected:
  void SetUp() override {
    V4l2Live::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    control_ = UniqueFd(::open(options_.device.c_str(), O_RDWR | O_CLOEXEC));
    ASSERT_TRUE(control_) << std::strerror(errno);
    v4l2_capability capability{};
    ASSERT_EQ(::ioctl(control_.value(), VIDIOC_QUERYCAP, &capability), 0);
    if (std::strcmp(reinterpret_cast<const char*>(capability.driver), "vivid") != 0) GTEST_SKIP() << "not vivid";
    watch();
  }
  void watch() {
    source_.reset();
    const auto open_camera = [this]() -> Result<std::unique_ptr<FrameSource>> {
      auto opened = open_v4l2_source(options_, clock_);
      if (!opened) return fail(opened.error());
      return std::move(*opened);
    };
    source_ = reconnecting({"camera", open_camera, {}}, clock_);
  }
  // Such as "Inject Fatal Streaming Error"; false: there is no such control.
  bool inject(std::string_view name, int value) {
    v4l2_queryctrl query{};
    query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
    for (; ::ioctl(control_.value(), VIDIOC_QUERYCTRL, &query) == 0; query.id |= V4L2_CTRL_FLAG_NEXT_CTRL) {
      if (name != reinterpret_cast<const char*>(query.name)) continue;
      v4l2_control control{query.id, value};
      return ::ioctl(control_.value(), VIDIOC_S_CTRL, &control) == 0;
    }
    return false;
  }
  // Time until a good frame arrives, however many failures occur meanwhile.
  Duration until_good(Duration longest = 30s) {
    const auto from = clock_.now();
    while (clock_.now() - from < longest) {
      const auto frame = source_->next(clock_.now() + 100ms);
      if (frame && frame->metadata.status == FrameStatus::good) return clock_.now() - from;
    }
    return Duration::max();
  }
  bool disconnects_soon() {
    for (const auto until = clock_.now() + 20s; clock_.now() < until;) {
      const auto frame = source_->next(clock_.now() + 100ms);
      if (!frame && frame.error().kind == FaultKind::disconnected) return true;
    }
    return false;
  }
  void run(Duration time) {
    for (const auto until = clock_.now() + time; clock_.now() < until;) (void)source_->next(clock_.now() + 100ms);
  }
  void print(int row, std::string_view what, Duration time, Duration allowed) {
    std::cout << fmt::format("row {:2}: {}: {:.2f} s (allowed {:.0f}); {}\n", row, what, to_seconds(time),
                             to_seconds(allowed), source_->health().cause);
    EXPECT_LE(time, allowed) << what;
  }

  UniqueFd control_;
  std::unique_ptr<ReconnectingSource> source_;
};

TEST_F(VividLive, Row4RefusedCallsWorkAtTheNextAttempt) {
  for (const char* name : {"Inject VIDIOC_REQBUFS Error", "Inject VIDIOC_QBUF Error", "Inject VIDIOC_STREAMON Error"}) {
    watch();
    ASSERT_TRUE(inject(name, 1)) << name;
    const auto from = clock_.now();
    ASSERT_TRUE(disconnects_soon()) << name;
    const std::string call = std::string(name).substr(7, std::string(name).size() - 13);  // "Inject VIDIOC_QBUF Error"
    EXPECT_NE(source_->health().cause.find(call), std::string::npos) << source_->health().cause;
    std::cout << source_->health().cause << "\n";
    ASSERT_LT(until_good(), 10s);
    print(4, name, clock_.now() - from, 4s);
  }
}

TEST_F(VividLive, Row6FramesResumeAfterAStall) {
  ASSERT_LT(until_good(), 8s);
  ASSERT_TRUE(inject("Percentage of Dropped Buffers", 100));
  const auto from = clock_.now();
  ASSERT_TRUE(disconnects_soon());
  print(6, "stall noticed", clock_.now() - from, 3s);
  ASSERT_TRUE(inject("Percentage of Dropped Buffers", 0));
  print(6, "frames after the stall", until_good(), 5s);
}

TEST_F(VividLive, Row7AFatalErrorIsOverSoon) {
  ASSERT_LT(until_good(), 8s);
  run(3s);
  ASSERT_TRUE(inject("Inject Fatal Streaming Error", 1));
  const auto from = clock_.now();
  ASSERT_TRUE(disconnects_soon());
  ASSERT_LT(until_good(), 10s);
  print(7, "frames after a fatal error", clock_.now() - from, 3s);
}

TEST_F(VividLive, Row8FlaggedFramesAreCountedAndTheNextIsGood) {
  ASSERT_LT(until_good(), 8s);
  ASSERT_TRUE(inject("Inject V4L2_BUF_FLAG_ERROR", 1));
  const auto before = source_->health();
  run(1s);
  const auto after = source_->health();
  EXPECT_GT(after.bad_frames.contains("flagged") ? after.bad_frames.at("flagged") : 0, 0u);
  print(8, "good frame after a flagged one", until_good(), 1s);
  EXPECT_EQ(after.opened, before.opened);
}

TEST_F(VividLive, Row11WrappingCountersAndTimesAreHandled) {
  ASSERT_TRUE(inject("Wrap Sequence Number", 1));
  ASSERT_TRUE(inject("Wrap Timestamp", 1));
  ASSERT_LT(until_good(), 8s);
  run(12s);
  const auto health = source_->health();
  std::cout << fmt::format("row 11: {} good, {} backwards, {} gaps, opened {}\n", health.good_frames, health.backwards,
                           health.sequence_gaps, health.opened);
  EXPECT_EQ(health.opened, 1u);
  inject("Wrap Sequence Number", 0);
  inject("Wrap Timestamp", 0);
}

// Must be last: vivid returns only when every descriptor is closed, including the test's own.
TEST_F(VividLive, Row1UnpluggingIsReportedAtOnceAndReplugRecovers) {
  ASSERT_LT(until_good(), 8s);
  ASSERT_TRUE(inject("Disconnect", 1));
  const auto from = clock_.now();
  ASSERT_TRUE(disconnects_soon());
  print(1, "unplugging noticed", clock_.now() - from, 1s);
  EXPECT_EQ(source_->health().cause, "unplugged");
  control_ = UniqueFd{};
  print(1, "frames after the last descriptor was closed", until_good(), 4s);
}

}  // namespace
}  // namespace kasumi
