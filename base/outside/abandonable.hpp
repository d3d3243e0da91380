// Work that may never end, since it waits for a disk that does not answer: in a thread of its own, which is left behind
// then.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include <pthread.h>

#include "base/thread_annotations.hpp"

namespace kasumi {

// How many abandoned threads still run. While any does, the program must end by std::_Exit(): destructors would destroy
// objects that such a thread uses.
inline std::atomic<int> abandoned_threads = 0;

// What the work uses must live as long as it does: hand in values, not references. Throws std::system_error where the
// machine has no thread left.
template <class T>
class Abandonable {
 public:
  explicit Abandonable(std::function<T()> work) : shared_(std::make_shared<Shared>()) {
    sigset_t all, before;  // signals are for the program's own threads
    sigfillset(&all);
    ::pthread_sigmask(SIG_BLOCK, &all, &before);
    ++abandoned_threads;
    auto run = [shared = shared_, work = std::move(work)]() mutable {
      std::optional<T> made;
      std::exception_ptr thrown;
      try {
        made = work();
      } catch (...) {
        thrown = std::current_exception();
      }
      work = nullptr;
      const MutexLock lock(shared->mutex);
      shared->made = std::move(made);
      shared->thrown = thrown;
      shared->ended = true;
      shared->woken.notify_all();
      --abandoned_threads;
    };
    try {
      std::thread(std::move(run)).detach();
    } catch (...) {
      --abandoned_threads;
      ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
      throw;
    }
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }

  // BLOCKS until it has ended, for at most `longest` by the machine's clock. Empty: it has not. What it throws is thrown.
  std::optional<T> take(std::chrono::nanoseconds longest) {
    const auto until = std::chrono::steady_clock::now() + longest;
    const MutexLock lock(shared_->mutex);
    while (!shared_->ended)
      if (shared_->woken.wait_until(shared_->mutex, until) == std::cv_status::timeout) break;
    if (!shared_->ended) return std::nullopt;
    if (shared_->thrown) std::rethrow_exception(shared_->thrown);
    return std::exchange(shared_->made, std::nullopt);
  }

  bool has_ended() const {
    const MutexLock lock(shared_->mutex);
    return shared_->ended;
  }

 private:
  struct Shared {
    Mutex mutex;
    std::condition_variable_any woken;
    std::optional<T> made KASUMI_GUARDED_BY(mutex);
    std::exception_ptr thrown KASUMI_GUARDED_BY(mutex);
    bool ended KASUMI_GUARDED_BY(mutex) = false;
  };
  std::shared_ptr<Shared> shared_;
};

// BLOCKS for at most `longest`. Empty: the work has not ended, and is left behind.
template <class T>
std::optional<T> within(std::chrono::nanoseconds longest, std::function<T()> work) {
  return Abandonable<T>(std::move(work)).take(longest);
}

// The same again and again, for a loop that must not wait: while one piece of work hangs, none is begun.
template <class T>
class OneAtATime {
 public:
  // BLOCKS for at most `longest`. Empty: it has not ended, in which case its result is lost, or was not begun, for that
  // reason or because the machine has no thread left.
  std::optional<T> within(std::chrono::nanoseconds longest, std::function<T()> work) {
    if (last_ && !last_->has_ended()) return std::nullopt;
    try {
      last_.emplace(std::move(work));
    } catch (const std::system_error&) {
      last_.reset();
      return std::nullopt;
    }
    return last_->take(longest);
  }

 private:
  std::optional<Abandonable<T>> last_;
};

}  // namespace kasumi
