#include "pipeline/kiosk/start/state_writer.hpp"

#include <algorithm>
#include <condition_variable>
#include <exception>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

#include "base/outside/abandonable.hpp"
#include "base/thread_annotations.hpp"

namespace kasumi {

namespace {

using SteadyTime = std::chrono::steady_clock::time_point;

void run_guarded(const std::string& name, const std::function<void()>& job) try {
  job();
} catch (const std::exception& thrown) {
  spdlog::warn("{}: not written: {}", name, thrown.what());
}

}  // namespace

struct StateWriter::Shared {
  struct Job {
    std::string name;
    std::function<void()> run;
    SteadyTime not_before;
  };
  mutable Mutex mutex;
  std::condition_variable_any changed;
  std::vector<Job> waiting KASUMI_GUARDED_BY(mutex);
  std::optional<SteadyTime> began KASUMI_GUARDED_BY(mutex);
  bool hurried KASUMI_GUARDED_BY(mutex) = false;  // a caller waits: do it at once
  bool ending KASUMI_GUARDED_BY(mutex) = false;

  bool is_idle() const KASUMI_THREAD_ANNOTATION(requires_capability(mutex)) { return waiting.empty() && !began; }

  // Empty: the writer ends.
  std::optional<Job> next() {
    const MutexLock lock(mutex);
    began.reset();
    changed.notify_all();
    for (;;) {
      const auto now = std::chrono::steady_clock::now();
      const auto due = std::ranges::find_if(waiting, [&](const Job& job) { return hurried || job.not_before <= now; });
      if (due != waiting.end()) {
        auto job = std::move(*due);
        waiting.erase(due);
        began = now;
        return job;
      }
      hurried = false;
      if (ending) return std::nullopt;
      if (waiting.empty())
        changed.wait(mutex);
      else
        changed.wait_until(mutex, std::ranges::min(waiting, {}, &Job::not_before).not_before);
    }
  }
};

StateWriter::StateWriter() : shared_(std::make_shared<Shared>()) {
  Abandonable<bool>([shared = shared_] {
    while (const auto job = shared->next()) run_guarded(job->name, job->run);
    return true;
  });
}

StateWriter::~StateWriter() {
  flush(std::chrono::seconds(1));
  const MutexLock lock(shared_->mutex);
  shared_->waiting.clear();
  shared_->ending = true;
  shared_->changed.notify_all();
}

void StateWriter::post(const std::string& name, std::function<void()> job, Duration not_before) {
  const auto at = std::chrono::steady_clock::now() + not_before;
  const MutexLock lock(shared_->mutex);
  std::erase_if(shared_->waiting, [&](const auto& waiting) { return waiting.name == name; });
  shared_->waiting.push_back({name, std::move(job), at});
  shared_->changed.notify_all();
}

bool StateWriter::flush(Duration longest) {
  const auto until = std::chrono::steady_clock::now() + longest;
  const MutexLock lock(shared_->mutex);
  shared_->hurried = true;
  shared_->changed.notify_all();
  while (!shared_->is_idle())
    if (shared_->changed.wait_until(shared_->mutex, until) == std::cv_status::timeout) break;
  return shared_->is_idle();
}

bool StateWriter::do_now(const std::string& name, std::function<void()> job, Duration longest) {
  const bool hangs = busy().value_or(Duration{}) >= longest;
  post(name, std::move(job));
  return !hangs && flush(longest);
}

std::optional<Duration> StateWriter::busy() const {
  const MutexLock lock(shared_->mutex);
  if (!shared_->began) return std::nullopt;
  return std::chrono::steady_clock::now() - *shared_->began;
}

}  // namespace kasumi
