#include "capture/libcamera/last_task.hpp"

#include <utility>

namespace kasumi {

namespace {

// Does it when it is deleted, since libcamera offers no other way to have something done later in another thread.
class LastTask final : public libcamera::Object {
 public:
  explicit LastTask(std::function<void()> task) : task_(std::move(task)) {}
  LastTask(const LastTask&) = delete;
  LastTask& operator=(const LastTask&) = delete;
  ~LastTask() override { task_(); }

 private:
  std::function<void()> task_;
};

}  // namespace

void run_after_queued_tasks(const libcamera::Object& object, std::function<void()> last) {
  auto* task = new LastTask(std::move(last));
  task->moveToThread(object.thread());
  task->deleteLater();
}

}  // namespace kasumi
