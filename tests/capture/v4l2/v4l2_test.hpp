// A source on a fake camera and a clock that the test turns.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "tests/capture/known_frames.hpp"
#include "tests/capture/v4l2/fake_camera.hpp"
#include "tests/must.hpp"

namespace kasumi {

inline const FakeMode kNv12{V4L2_PIX_FMT_NV12, 64, 48};

inline int open_descriptors() {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}

class V4l2 : public testing::Test {
 protected:
  FakeCamera& camera(std::vector<FakeMode> modes) {
    camera_ = std::make_unique<FakeCamera>(std::move(modes), clock);
    return *camera_;
  }
  CameraRequest request(int width = 64, int height = 48) {
    CameraRequest request;
    request.width = width;
    request.height = height;
    return request;
  }
  Result<std::unique_ptr<CameraSource>> try_open(const CameraRequest& request) {
    return open_v4l2_source(camera_->open(), {"/dev/v4l/by-id/fake", request}, clock);
  }
  std::unique_ptr<CameraSource> open(const CameraRequest& request) {
    auto source = try_open(request);
    EXPECT_TRUE(source) << source.error().message;
    return source ? std::move(*source) : nullptr;
  }
  Result<Frame> next(FrameSource& source, Duration longest = 1s) { return source.next(clock.now() + longest); }

  FastForwardClock clock{Utc{std::chrono::sys_days{std::chrono::June / 21 / 2026}}};
  std::unique_ptr<FakeCamera> camera_;
};

}  // namespace kasumi
