// A camera through V4L2: the one KASUMI_V4L2_DEVICE names; skipped without. KASUMI_V4L2_SIZE: "640x360" when left out.
#include <gtest/gtest.h>

#include <fcntl.h>
#include <linux/videodev2.h>

#include <cstdlib>
#include <iostream>

#include "capture/v4l2/formats.hpp"
#include "capture/v4l2/v4l2_source.hpp"
#include "capture/v4l2/video_device.hpp"
#include "tests/must.hpp"

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
  const auto source = must(open());
  const auto& mode = source->mode();
  std::cout << fmt::format("{} {}x{} stride {}, {:.4g} /s, {}\n", mode.format.text(), mode.width, mode.height,
                           mode.stride, mode.frames_per_second,
                           mode.yuv_encoding ? name_of(*mode.yuv_encoding) : "no YUV");
  for (const auto& note : mode.notes) std::cout << "  " << note << "\n";
  std::optional<FrameMetadata> last;
  for (int i = 0; i < 30; ++i) {
    const auto frame = must(source->next(clock_.now() + 4s));
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
    auto device = must(open_video_device(options_.device));
    auto source = open_v4l2_source(std::make_unique<SeveralPlanesOnly>(std::move(*device)), options_, clock_);
    if (!source) GTEST_SKIP() << "offers no format with several memory planes: " << source.error().message;
    const auto gathered = must((*source)->next(clock_.now() + 4s));
    ASSERT_EQ(gathered->metadata.status, FrameStatus::good);
    EXPECT_EQ((*source)->frames_copied(), 1u);
    source->reset();
    const auto plain = must(open());
    const auto lent = must(plain->next(clock_.now() + 4s));
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
  const auto source = must(open());
  for (const auto& note : source->mode().notes) std::cout << "  " << note << "\n";
  if (!source->mode().gain) GTEST_SKIP() << "it has no gain";
  EXPECT_EQ(source->mode().gain, 100.0);
}

TEST_F(V4l2Live, HoldingFramesDoesNotStarveIt) {
  const auto source = must(open());
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
    auto source = must(open());
    auto held = must(source->next(clock_.now() + 4s));
    source.reset();
    const auto again = must(open());
    ASSERT_TRUE(again->next(clock_.now() + 4s));
    const auto first = held->payload.bytes.front();  // still mapped
    EXPECT_EQ(first, held->payload.bytes.front());
  }
  EXPECT_EQ(open_descriptors(), before);
}

}  // namespace
}  // namespace kasumi
