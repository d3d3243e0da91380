// What drivers answer: damaged frames, impossible sizes, errors, the end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>

#include "tests/capture/v4l2/v4l2_test.hpp"

namespace kasumi {
namespace {

using testing::HasSubstr;

TEST_F(V4l2, FlaggedEmptyAndShortFramesReportTheirStatusAndTheStreamContinues) {
  camera({kNv12}).tamper([](FakeAnswer& answer) {
    if (answer.number % 4 == 1) answer.buffer.flags |= V4L2_BUF_FLAG_ERROR;
    if (answer.number % 4 == 2) answer.planes[0].bytesused = 0;
    if (answer.number % 4 == 3) answer.planes[0].bytesused -= 1;
  });
  auto source = open(request());
  const std::array expected{FrameStatus::good, FrameStatus::flagged, FrameStatus::truncated, FrameStatus::truncated};
  for (std::uint32_t i = 0; i < 40; ++i) {
    const auto frame = must(next(*source));
    EXPECT_EQ(frame->metadata.sequence, i) << "every buffer was requeued";
    EXPECT_EQ(frame->metadata.status, expected[i % 4]) << i;
  }
}

TEST_F(V4l2, NoMoreBytesAreReadThanTheBufferHolds) {
  camera({kNv12}).tamper([](FakeAnswer& answer) { answer.planes[0].bytesused = 0xffffffff; });
  auto source = open(request());
  const auto frame = must(next(*source));
  EXPECT_EQ(frame->metadata.status, FrameStatus::flagged);
  EXPECT_EQ(frame->payload.bytes.size(), 64u * 48 * 3 / 2);
  EXPECT_EQ(camera_->with_driver(), 6);
}

TEST_F(V4l2, ABufferThatIsNotQueuedIsAFault) {
  for (const std::uint32_t index : {6u, 31u, 0xffffffffu}) {
    camera({kNv12}).tamper([&](FakeAnswer& answer) { answer.buffer.index = index; });
    auto source = open(request());
    EXPECT_THAT(next(*source), FailsAs(FaultKind::device, HasSubstr(fmt::format("buffer {}", index))));
  }
  camera({kNv12});  // the same one twice
  camera_->tamper([](FakeAnswer& answer) { answer.buffer.index = 0; });
  auto source = open(request());
  const auto first = next(*source);
  ASSERT_TRUE(first);
  const auto second = next(*source);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().kind, FaultKind::device);
}

TEST_F(V4l2, StridesAndSizesTooSmallForThePictureAreRefused) {
  const auto refused_with = [&](std::function<void(v4l2_pix_format&)> change) {
    camera({kNv12}).lie([change](unsigned long code, void* argument) {
      if (code == VIDIOC_S_FMT) change(static_cast<v4l2_format*>(argument)->fmt.pix);
    });
    const auto source = try_open(request());
    EXPECT_EQ(camera_->opened(), source ? 1 : 0);
    return source ? std::string("opened") : source.error().message;
  };
  EXPECT_THAT(refused_with([](auto& pix) { pix.bytesperline = 63; }), HasSubstr("63 bytes in a row"));
  EXPECT_THAT(refused_with([](auto& pix) { pix.bytesperline = 1u << 31; }), HasSubstr("bytes in a row"));
  EXPECT_THAT(refused_with([](auto& pix) { pix.sizeimage = 64 * 48; }), HasSubstr("3072 bytes for a picture"));
  EXPECT_THAT(refused_with([](auto& pix) { pix.sizeimage = 0xffffffff; }), HasSubstr("expected at most"));
  EXPECT_THAT(refused_with([](auto& pix) { pix.width = 32; }), HasSubstr("it would give NV12 32x48"));
  EXPECT_THAT(refused_with([](auto& pix) { pix.field = V4L2_FIELD_ALTERNATE; }), HasSubstr("single fields"));
  EXPECT_EQ(refused_with([](auto& pix) { pix.bytesperline = 0; }), "opened") << "old drivers mean: packed";
}

TEST_F(V4l2, BuffersThatAreTooSmallOrTooFewAreRefused) {
  camera({kNv12}).lie([](unsigned long code, void* argument) {
    if (code == VIDIOC_QUERYBUF) static_cast<v4l2_buffer*>(argument)->length = 4095;
  });
  EXPECT_THAT(try_open(request()).error().message, HasSubstr("buffer 0 has 4095 bytes"));
  EXPECT_EQ(camera_->mapped(), 0);
  camera({kNv12}).most_buffers = 1;
  EXPECT_THAT(try_open(request()).error().message, HasSubstr("1 buffers"));
  camera({kNv12}).lie([](unsigned long code, void* argument) {
    if (code == VIDIOC_REQBUFS) static_cast<v4l2_requestbuffers*>(argument)->count = 1000;
  });
  EXPECT_THAT(try_open(request()).error().message, HasSubstr("1000 buffers"));
}

TEST_F(V4l2, AnUnpluggedCameraIsReportedAtOnceAndPermanently) {
  camera({kNv12});
  auto source = open(request());
  ASSERT_TRUE(next(*source));
  camera_->unplug();
  const auto at = clock.now();
  const auto gone = next(*source, 10s);
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error().kind, FaultKind::disconnected);
  EXPECT_EQ(clock.now(), at);
  camera_->plug_in();
  EXPECT_EQ(next(*source).error().kind, FaultKind::disconnected) << "another camera may have come";
}

TEST_F(V4l2, AFailedQueueIsAFaultWithTheDriversError) {
  camera({kNv12});
  auto source = open(request());
  ASSERT_TRUE(next(*source));
  camera_->fail_queue();
  const auto at = clock.now();
  EXPECT_THAT(next(*source, 10s), FailsAs(FaultKind::device, HasSubstr("Input/output error")));
  EXPECT_EQ(clock.now(), at);
}

TEST_F(V4l2, ABufferThatCannotBeRequeuedIsAFault) {
  camera({kNv12});
  auto source = open(request());
  auto frame = must(next(*source));
  camera_->refuse(VIDIOC_QBUF, EINVAL);
  *frame = Frame{};
  EXPECT_THAT(next(*source), FailsWith(HasSubstr("VIDIOC_QBUF")));
}

TEST_F(V4l2, ASourceThatChangesItsSizeIsAFault) {
  camera({kNv12});
  auto source = open(request());
  ASSERT_TRUE(next(*source));
  camera_->announce_source_change();
  EXPECT_THAT(next(*source), FailsWith(HasSubstr("changed size")));
}

TEST_F(V4l2, TheEndOfAStreamIsAFault) {
  camera({kNv12});
  auto source = open(request());
  camera_->refuse(VIDIOC_DQBUF, EPIPE);
  EXPECT_THAT(next(*source).error().message, HasSubstr("ended the stream"));
}

}  // namespace
}  // namespace kasumi
