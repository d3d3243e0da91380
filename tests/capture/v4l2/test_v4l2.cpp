#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <linux/v4l2-controls.h>

#include <atomic>
#include <future>
#include <thread>

#include "base/latest_slot.hpp"
#include "tests/capture/v4l2/v4l2_test.hpp"

namespace kasumi {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

std::vector<Rgb8> pixels(const PictureView& view) {
  return to_rgb(view).elements();
}

// --- frames

TEST_F(V4l2, FramesArriveOnTimeWithTheDriversMetadata) {
  camera({kNv12}).latency = 5ms;
  auto source = open(request());
  const auto start = clock.now();
  for (std::uint32_t i = 0; i < 20; ++i) {
    const auto frame = must(next(*source));
    const auto at = start + 40ms * (i + 1);
    EXPECT_EQ(frame->metadata.sequence, i);
    EXPECT_EQ(frame->metadata.captured_at, at);
    EXPECT_EQ(frame->metadata.utc, clock.utc() - 5ms);
    EXPECT_EQ(clock.now(), at + 5ms);
    EXPECT_EQ(frame->metadata.status, FrameStatus::good);
    EXPECT_EQ(frame->metadata.bytes_used, 64u * 48 * 3 / 2);
    EXPECT_EQ(frame->metadata.stride, 64u);
    EXPECT_EQ(frame->metadata.skipped, 0u);
    EXPECT_THAT(frame->payload.bytes, testing::Each(i));
  }
  EXPECT_EQ(source->frames_copied(), 0u);
}

TEST_F(V4l2, EveryFormatDecodesToTheEncodedPicture) {
  struct Case {
    std::uint32_t code;
    const char (&format)[5];
  };
  const auto picture = test_picture(64, 48);
  for (const auto& [code, format] :
       {Case{V4L2_PIX_FMT_YUYV, "YUYV"}, Case{V4L2_PIX_FMT_UYVY, "UYVY"}, Case{V4L2_PIX_FMT_NV12, "NV12"},
        Case{V4L2_PIX_FMT_YUV420, "YU12"}, Case{V4L2_PIX_FMT_RGB24, "RGB3"}, Case{V4L2_PIX_FMT_BGR24, "BGR3"},
        Case{V4L2_PIX_FMT_XBGR32, "XR24"}, Case{V4L2_PIX_FMT_ABGR32, "XR24"}, Case{V4L2_PIX_FMT_BGR32, "XR24"},
        Case{V4L2_PIX_FMT_RGBX32, "AB24"}, Case{V4L2_PIX_FMT_RGBA32, "AB24"}, Case{V4L2_PIX_FMT_GREY, "GREY"},
        Case{V4L2_PIX_FMT_MJPEG, "MJPG"}, Case{V4L2_PIX_FMT_JPEG, "MJPG"}}) {
    SCOPED_TRACE(format);
    const std::uint32_t padding = code == V4L2_PIX_FMT_MJPEG || code == V4L2_PIX_FMT_JPEG ? 0 : 16;
    FakeMode mode{code, 64, 48, {{1, 30}}, padding};
    EncodingFormat options;
    if (padding != 0)
      options.stride = static_cast<std::uint32_t>(plane_size(*layout_of(four_cc(format)), 64, 48, 0).row_bytes) + 16;
    const auto encoded = encode_frame(picture, four_cc(format), options).value();
    camera({mode}).content = [&](std::uint32_t) {
      return std::vector<std::vector<std::uint8_t>>{{encoded.payload.bytes.begin(), encoded.payload.bytes.end()}};
    };
    auto source = must(open(request()));
    EXPECT_EQ(source->mode().format, four_cc(format));
    const auto frame = must(next(*source));
    const auto got = must(decode(*frame, YuvEncoding::bt601_full)), expected = decode(encoded, YuvEncoding::bt601_full);
    EXPECT_EQ(pixels(got->view()), pixels(expected->view()));
  }
}

TEST_F(V4l2, PlanesInSeparateMemoriesAreGathered) {
  const auto picture = test_picture(62, 46);
  struct Case {
    std::uint32_t code;
    const char (&format)[5];
  };
  for (const auto& [code, format] : {Case{V4L2_PIX_FMT_NV12M, "NV12"}, Case{V4L2_PIX_FMT_YUV420M, "YU12"}}) {
    SCOPED_TRACE(format);
    camera({{code, 62, 46, {{1, 30}}, 10}}).multiplanar = true;  // rows of 72 and of 72 or 41 bytes
    const auto layout = *layout_of(four_cc(format));
    const auto encoded = encode_frame(picture, four_cc(format)).value();
    const auto view = decode(encoded, YuvEncoding::bt601_full).value();
    camera_->content = [&](std::uint32_t) {
      std::vector<std::vector<std::uint8_t>> planes;
      for (int i = 0; i < plane_count(layout); ++i) {
        const auto size = plane_size(layout, 62, 46, i);
        const auto& plane = view.view().planes[static_cast<std::size_t>(i)];
        auto& bytes = planes.emplace_back();
        for (int y = 0; y < size.rows; ++y) {
          const auto* row = plane.data + static_cast<std::size_t>(y) * plane.stride;
          bytes.insert(bytes.end(), row, row + size.row_bytes);
          bytes.insert(bytes.end(), 10, 0xee);
        }
      }
      return planes;
    };
    auto source = must(open(request(62, 46)));
    const auto frame = must(next(*source));
    EXPECT_EQ(frame->metadata.status, FrameStatus::good);
    const auto got = must(decode(*frame, YuvEncoding::bt601_full));
    EXPECT_EQ(pixels(got->view()), pixels(view.view()));
    EXPECT_EQ(source->frames_copied(), 1u);
    EXPECT_EQ(camera_->with_driver(), 6);
  }
}

TEST_F(V4l2, AMultiplanarDriverWithOneMemoryPlaneLendsItFromItsDataOffset) {
  camera({kNv12}).multiplanar = true;
  camera_->tamper([](FakeAnswer& answer) { answer.planes[0].data_offset = 128; });
  auto lent = open(request());
  const auto frame = must(next(*lent));
  EXPECT_EQ(frame->metadata.status, FrameStatus::truncated) << "128 bytes too few remain after the header";
  camera_->tamper({});
  const auto whole = must(next(*lent));
  EXPECT_EQ(whole->metadata.status, FrameStatus::good);
  ASSERT_TRUE(whole->payload.dma_buf);
  EXPECT_EQ(whole->payload.dma_buf->offset, 0u);
}

TEST_F(V4l2, TheNewestFrameWinsAndOlderOnesAreRequeued) {
  camera({kNv12});
  auto source = open(request());
  ASSERT_TRUE(next(*source));
  clock.sleep_until(clock.now() + 130ms);  // three more
  const auto frame = must(next(*source, 0s));
  EXPECT_EQ(frame->metadata.sequence, 3u);
  EXPECT_EQ(frame->metadata.skipped, 2u);
  EXPECT_EQ(camera_->with_driver(), 5);
}

TEST_F(V4l2, WithoutAMonotonicTimestampTheArrivalTimeIsUsed) {
  camera({kNv12}).latency = 7ms;
  camera_->tamper([](FakeAnswer& answer) { answer.buffer.flags = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN; });
  auto source = open(request());
  const auto frame = must(next(*source));
  EXPECT_EQ(frame->metadata.captured_at, clock.now());
  EXPECT_EQ(frame->metadata.utc, clock.utc());
}

TEST_F(V4l2, AMissingFrameIsATimeoutAtTheDeadline) {
  camera({kNv12}).stop_filling(true);
  auto source = open(request());
  const auto deadline = clock.now() + 300ms;
  const auto frame = source->next(deadline);
  ASSERT_FALSE(frame);
  EXPECT_EQ(frame.error().kind, FaultKind::timeout);
  EXPECT_EQ(clock.now(), deadline);
}

// --- lending

TEST_F(V4l2, FramesStayInTheDriversBuffersUntilReleased) {
  camera({kNv12});
  auto source = open(request());
  auto frame = must(next(*source));
  EXPECT_EQ(camera_->with_driver(), 5);
  ASSERT_TRUE(frame->payload.dma_buf);
  EXPECT_GE(frame->payload.dma_buf->fd, 0);
  auto picture = must(decode(*frame, YuvEncoding::bt601_full));
  EXPECT_EQ(picture->dma_buf()->buffer, frame->payload.dma_buf->buffer);
  *frame = Frame{};
  EXPECT_EQ(camera_->with_driver(), 5) << "the picture still holds the buffer";
  *picture = DecodedPicture{};
  EXPECT_EQ(camera_->with_driver(), 5) << "a reader makes no call into the driver";
  EXPECT_FALSE(next(*source, 0s));
  EXPECT_EQ(camera_->with_driver(), 6);
}

TEST_F(V4l2, EachBufferOfAStreamHasItsOwnNumber) {
  camera({kNv12});
  std::map<const std::uint8_t*, std::uint64_t> numbers;
  std::set<std::uint64_t> distinct;
  for (int round = 0; round < 2; ++round) {
    auto source = open(request());
    std::map<const std::uint8_t*, std::uint64_t> now;
    for (int i = 0; i < 12; ++i) {
      const auto frame = must(next(*source));
      const auto [entry, added] = now.emplace(frame->payload.bytes.data(), frame->payload.dma_buf->buffer);
      EXPECT_EQ(entry->second, frame->payload.dma_buf->buffer);
      EXPECT_EQ(distinct.insert(entry->second).second, added);
    }
  }
}

TEST_F(V4l2, HoldingFramesDoesNotStarveTheCamera) {
  camera({kNv12});
  auto source = open(request());
  std::vector<Frame> held;
  for (std::uint32_t i = 0; i < 20; ++i) {
    auto frame = must(next(*source));
    EXPECT_EQ(frame->metadata.sequence, i) << "no frame was lost";
    EXPECT_EQ(frame->payload.dma_buf.has_value(), i < 4) << "six buffers, of which the driver keeps two";
    held.push_back(std::move(*frame));
  }
  EXPECT_EQ(source->frames_copied(), 16u);
  for (std::uint32_t i = 0; i < 20; ++i) EXPECT_THAT(held[i].payload.bytes, testing::Each(i));
  held.clear();
  EXPECT_FALSE(next(*source, 0s));
  EXPECT_EQ(camera_->with_driver(), 6);
}

TEST_F(V4l2, CopiesHoldNoDriverBuffers) {
  camera({kNv12});
  auto wanted = request();
  wanted.lend_buffers = false;
  auto source = open(wanted);
  const auto frame = must(next(*source));
  EXPECT_FALSE(frame->payload.dma_buf);
  EXPECT_EQ(camera_->with_driver(), 6);
  source.reset();
  EXPECT_EQ(camera_->opened(), 0);
  EXPECT_THAT(frame->payload.bytes, testing::Each(0));
}

TEST_F(V4l2, FramesOfALoopbackThatOverwritesBuffersAreCopied) {
  camera({kNv12}).driver = "v4l2 loopback";
  camera_->shared = true;
  camera_->exports = false;
  camera_->most_buffers = 3;
  auto source = open(request());
  std::vector<Frame> held;
  for (int i = 0; i < 20; ++i) {
    clock.sleep_until(clock.now() + 40ms * (i % 5));  // now and then more frames than there are buffers
    auto frame = next(*source);
    ASSERT_TRUE(frame) << i << ": " << frame.error().message;
    held.push_back(std::move(*frame));
  }
  for (const auto& frame : held) EXPECT_THAT(frame.payload.bytes, testing::Each(frame.metadata.sequence));
  EXPECT_EQ(source->frames_copied(), 20u);
}

TEST_F(V4l2, ADriverWithoutDmabufExportStillLendsItsMemory) {
  camera({kNv12}).exports = false;
  auto source = open(request());
  const auto frame = must(next(*source));
  EXPECT_FALSE(frame->payload.dma_buf);
  EXPECT_EQ(camera_->with_driver(), 5);
}

TEST_F(V4l2, FramesMayBeReleasedInAnotherThread) {
  SystemClock real;
  FakeCamera fast({kNv12}, real);
  fast.interval = 200us;
  auto source = open_v4l2_source(fast.open(), {"/dev/v4l/by-id/fake", request()}, real).value();
  LatestSlot<Frame> slot;
  std::atomic<bool> ended{false};
  std::thread reader([&] {
    while (!ended) {
      const auto frame = slot.take();
      if (!frame) continue;
      EXPECT_EQ(frame->payload.bytes.front(), static_cast<std::uint8_t>(frame->metadata.sequence));
    }
  });
  for (int i = 0; i < 300; ++i) {
    auto frame = source->next(real.now() + 5s);
    EXPECT_TRUE(frame) << frame.error().message;
    if (frame) slot.put(std::move(*frame));
  }
  source.reset();  // while the reader may hold one
  ended = true;
  reader.join();
  slot.take();
  EXPECT_EQ(fast.mapped(), 0);
  EXPECT_EQ(fast.opened(), 0);
}

// A driver with a call that does not return.
class StuckDevice final : public VideoDevice {
 public:
  struct Gate {
    std::atomic<unsigned long> closed = 0;  // the request that does not return; 0: none
    std::atomic<bool> inside = false;
  };
  StuckDevice(std::unique_ptr<VideoDevice> device, Gate& gate) : device_(std::move(device)), gate_(gate) {}
  int control(unsigned long request, void* argument) override {
    while (gate_.closed == request) {
      gate_.inside = true;
      std::this_thread::sleep_for(1ms);
    }
    return device_->control(request, argument);
  }
  VideoEvents wait(Duration longest) override { return device_->wait(longest); }
  std::span<const std::uint8_t> map(std::size_t length, std::int64_t offset, int& error) override {
    return device_->map(length, offset, error);
  }
  void unmap(std::span<const std::uint8_t> mapped) override { device_->unmap(mapped); }

 private:
  const std::unique_ptr<VideoDevice> device_;
  Gate& gate_;
};

// The render thread releases frames: no driver may hold it up.
TEST_F(V4l2, ADriverThatHangsDoesNotHoldUpWhoeverReleasesAFrame) {
  for (const unsigned long request_that_hangs : {VIDIOC_STREAMOFF, VIDIOC_QBUF, VIDIOC_DQBUF, VIDIOC_REQBUFS}) {
    SystemClock real;
    FakeCamera fast({kNv12}, real);
    fast.interval = 1ms;
    StuckDevice::Gate gate;
    auto source =
        open_v4l2_source(std::make_unique<StuckDevice>(fast.open(), gate), {"/dev/v4l/by-id/fake", request()}, real)
            .value();
    auto first = source->next(real.now() + 5s), second = source->next(real.now() + 5s);
    ASSERT_TRUE(first && second);
    *first = Frame{};
    gate.closed = request_that_hangs;
    std::thread camera([&] {
      const bool closes = request_that_hangs == VIDIOC_STREAMOFF || request_that_hangs == VIDIOC_REQBUFS;
      if (!closes) (void)source->next(real.now() + 100ms);
      source.reset();
    });
    while (!gate.inside) std::this_thread::sleep_for(1ms);
    auto released = std::async(std::launch::async, [&] { *second = Frame{}; });
    EXPECT_EQ(released.wait_for(2s), std::future_status::ready) << "request " << request_that_hangs;
    gate.closed = 0;
    camera.join();
    released.wait();
    EXPECT_EQ(fast.mapped(), 0);
    EXPECT_EQ(fast.opened(), 0);
  }
}

// --- teardown

TEST_F(V4l2, AClosedSourceLeavesNothingBehind) {
  const int before = open_descriptors();
  camera({kNv12});
  for (int i = 0; i < 5; ++i) {
    auto source = open(request());
    ASSERT_TRUE(next(*source));
    source.reset();
    EXPECT_EQ(camera_->mapped(), 0);
    EXPECT_EQ(camera_->opened(), 0);
    EXPECT_FALSE(camera_->streaming());
    EXPECT_FALSE(camera_->allocated());
    EXPECT_EQ(open_descriptors(), before);
  }
}

TEST_F(V4l2, AHeldFrameOutlivesItsSourceAndTheCameraCanBeReopenedMeanwhile) {
  camera({kNv12});
  const int before = open_descriptors();
  auto source = open(request());
  auto held = must(next(*source));
  source.reset();
  EXPECT_FALSE(camera_->streaming());
  EXPECT_EQ(camera_->mapped(), 1) << "only what is held";
  EXPECT_EQ(camera_->opened(), 1);
  EXPECT_THAT(held->payload.bytes, testing::Each(0));
  auto again = must(open(request()));
  EXPECT_TRUE(next(*again));
  *held = Frame{};
  EXPECT_TRUE(next(*again)) << "releasing it affects nothing else";
  again.reset();
  EXPECT_EQ(camera_->mapped(), 0);
  EXPECT_EQ(camera_->opened(), 0);
  EXPECT_EQ(open_descriptors(), before);
}

TEST_F(V4l2, AnOldKernelsBuffersAreFreedWithTheLastFrame) {
  camera({kNv12}).keeps_orphans = false;
  auto source = open(request());
  auto held = next(*source);
  source.reset();
  EXPECT_TRUE(camera_->allocated());
  EXPECT_THAT(try_open(request()), FailsAs(FaultKind::device, HasSubstr("in use")));
  *held = Frame{};
  EXPECT_FALSE(camera_->allocated());
  EXPECT_TRUE(open(request()));
}

TEST_F(V4l2, AFailureAtAnyStepOfOpeningLeavesNothingBehind) {
  const int before = open_descriptors();
  for (const auto& [request_code, name] :
       {std::pair{VIDIOC_QUERYCAP, "VIDIOC_QUERYCAP"}, std::pair{VIDIOC_S_FMT, "VIDIOC_S_FMT"},
        std::pair{VIDIOC_REQBUFS, "VIDIOC_REQBUFS"}, std::pair{VIDIOC_QUERYBUF, "VIDIOC_QUERYBUF"},
        std::pair{VIDIOC_QBUF, "VIDIOC_QBUF"}, std::pair{VIDIOC_STREAMON, "VIDIOC_STREAMON"}}) {
    SCOPED_TRACE(name);
    camera({kNv12}).refuse(request_code, EIO, 1);
    EXPECT_THAT(try_open(request()), FailsAs(FaultKind::device, HasSubstr(name)));
    EXPECT_EQ(camera_->opened(), 0);
    EXPECT_EQ(camera_->mapped(), 0);
    EXPECT_FALSE(camera_->allocated());
    EXPECT_EQ(open_descriptors(), before);
    EXPECT_TRUE(open(request())) << "opening works the next time";
  }
}

TEST_F(V4l2, UnpluggingAtAnyStepOfOpeningIsADisconnect) {
  for (const auto step : {VIDIOC_QUERYCAP, VIDIOC_S_FMT, VIDIOC_REQBUFS, VIDIOC_QUERYBUF, VIDIOC_QBUF, VIDIOC_STREAMON,
                          VIDIOC_QUERYCTRL}) {
    camera({kNv12}).refuse(step, ENODEV);
    const auto refused = try_open(request());
    ASSERT_FALSE(refused) << step;
    EXPECT_EQ(refused.error().kind, FaultKind::disconnected) << refused.error().message;
    EXPECT_EQ(camera_->mapped(), 0);
  }
}

}  // namespace
}  // namespace kasumi
