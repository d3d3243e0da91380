// A camera through libcamera: the one that KASUMI_LIBCAMERA_CAMERA names, else the first found; skipped where there is
// none. vimc's 'Sensor B' is sufficient.
#include <gtest/gtest.h>

#include <cstdlib>
#include <set>
#include <thread>

#include "capture/libcamera/libcamera_source.hpp"
#include "tests/must.hpp"

namespace kasumi {
namespace {

using namespace std::chrono_literals;

class LibcameraLive : public testing::Test {
 protected:
  void SetUp() override {
    if (const char* named = std::getenv("KASUMI_LIBCAMERA_CAMERA")) {
      options_.camera = named;
    } else {
      const auto listed = list_libcamera_cameras();
      if (!listed) GTEST_SKIP() << listed.error().message;
      if (listed->empty()) GTEST_SKIP() << "libcamera sees no camera on this machine";
      options_.camera = listed->front().id;
    }
    options_.request.width = 480;  // vimc: multiples of 6 only
    options_.request.height = 360;
  }
  std::unique_ptr<CameraSource> open() {
    auto source = open_libcamera_source(options_, clock_);
    EXPECT_TRUE(source) << source.error().message;
    return source ? std::move(*source) : nullptr;
  }

  SystemClock clock_;
  LibcameraOptions options_;
};

TEST_F(LibcameraLive, FramesAreCompleteFreshAndDecodable) {
  const auto source = must(open());
  EXPECT_EQ(source->mode().width, 480);
  EXPECT_EQ(source->mode().height, 360);
  std::optional<FrameMetadata> last;
  for (int i = 0; i < 10; ++i) {
    const auto frame = must(source->next(clock_.now() + 4s));
    ASSERT_EQ(frame->metadata.status, FrameStatus::good);
    EXPECT_TRUE(decode(*frame, YuvEncoding::bt601_full));
    EXPECT_LT(std::chrono::abs(clock_.now() - frame->metadata.captured_at), 2s);
    if (last) {
      EXPECT_GT(frame->metadata.sequence, last->sequence);
      EXPECT_GT(frame->metadata.captured_at, last->captured_at);
    }
    last = frame->metadata;
  }
}

TEST_F(LibcameraLive, ACameraWhoseFramesAreKeptContinuesWithCopies) {
  const auto source = must(open());
  std::vector<Frame> kept;
  for (int i = 0; i < 8; ++i) {
    auto frame = must(source->next(clock_.now() + 4s));
    kept.push_back(std::move(*frame));
  }
  EXPECT_GT(source->frames_copied(), 0u);
  std::set<const void*> places;
  for (const auto& frame : kept) places.insert(frame.payload.bytes.data());
  EXPECT_EQ(places.size(), kept.size()) << "two kept frames share their memory";
}

TEST_F(LibcameraLive, FramesStayReadableAfterTheSourceIsGoneAndTheCameraReopens) {
  for (int round = 0; round < 3; ++round) {
    std::optional<Frame> kept;
    {
      const auto source = must(open());
      auto frame = must(source->next(clock_.now() + 4s));
      kept = std::move(*frame);
    }
    EXPECT_TRUE(decode(*kept, YuvEncoding::bt601_full));
  }
}

TEST_F(LibcameraLive, DeadlinesAreMet) {
  const auto source = must(open());
  const auto before = clock_.now();
  const auto frame = source->next(before);
  EXPECT_LT(clock_.now() - before, 1s);
  if (!frame) {
    EXPECT_EQ(frame.error().kind, FaultKind::timeout);
  }
}

TEST_F(LibcameraLive, AnImpossibleSizeIsRefusedWithTheSizesTheCameraOffers) {
  options_.request.width = 16001;
  options_.request.height = 3;
  const auto refused = open_libcamera_source(options_, clock_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, FaultKind::bad_input);
  EXPECT_NE(refused.error().message.find("expected one of"), std::string::npos) << refused.error().message;
}

TEST_F(LibcameraLive, ACameraThatIsThereIsPresent) {
  ASSERT_TRUE(open());
  EXPECT_TRUE(is_libcamera_camera_present(options_.camera));
  EXPECT_FALSE(is_libcamera_camera_present("no-such-camera"));
}

TEST(Libcamera, AnUnknownCameraIsReportedAsDisconnected) {
  SystemClock clock;
  const auto refused = open_libcamera_source({.camera = "no-such-camera", .request = {}}, clock);
  ASSERT_FALSE(refused);
  if (refused.error().kind == FaultKind::unsupported) GTEST_SKIP() << refused.error().message;
  EXPECT_EQ(refused.error().kind, FaultKind::disconnected);
  EXPECT_NE(refused.error().message.find("no-such-camera"), std::string::npos);
}

}  // namespace
}  // namespace kasumi
