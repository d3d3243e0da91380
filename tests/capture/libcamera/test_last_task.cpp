// Runs without a camera: an object in a thread of libcamera's stands for it.
#define LIBCAMERA_BASE_PRIVATE  // libcamera's threads are not meant for applications
#include "capture/libcamera/last_task.hpp"

#include <gtest/gtest.h>

#include <libcamera/base/thread.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

namespace kasumi {
namespace {

using namespace std::chrono_literals;

struct Buffer {
  std::atomic<int> written = 0;
  std::atomic<bool> freed = false;
  std::atomic<int> written_after = 0;
};

class Camera : public libcamera::Object {
 public:
  explicit Camera(Buffer& buffer) : buffer_(buffer) {}
  void write() {
    std::this_thread::sleep_for(5ms);
    ++(buffer_.freed ? buffer_.written_after : buffer_.written);
  }

 private:
  Buffer& buffer_;
};

TEST(LastTask, ACamerasThreadFreesWhatItsQueuedTasksStillUse) {
  Buffer buffer;
  libcamera::Thread thread;
  auto camera = std::make_unique<Camera>(buffer);
  camera->moveToThread(&thread);
  thread.start();
  for (int i = 0; i < 20; ++i) camera->invokeMethod(&Camera::write, libcamera::ConnectionTypeQueued);
  std::atomic<libcamera::Thread*> freed_by = nullptr;
  run_after_queued_tasks(*camera, [&] {
    camera.reset();  // as when the session holds the last reference
    buffer.freed = true;
    freed_by = libcamera::Thread::current();
  });
  for (int i = 0; i < 1000 && freed_by == nullptr; ++i) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(freed_by, &thread);
  EXPECT_EQ(buffer.written, 20);
  EXPECT_EQ(buffer.written_after, 0);
  thread.exit();
  thread.wait();
}

}  // namespace
}  // namespace kasumi
