// Annotations of what a mutex guards, checked by clang (-Wthread-safety) and ignored by other compilers.
#pragma once

#include <mutex>

#ifdef __clang__
#define KASUMI_THREAD_ANNOTATION(annotation) __attribute__((annotation))
#else
#define KASUMI_THREAD_ANNOTATION(annotation)
#endif

#define KASUMI_GUARDED_BY(mutex) KASUMI_THREAD_ANNOTATION(guarded_by(mutex))

namespace kasumi {

// Annotated equivalents of std::mutex and std::lock_guard, which libstdc++ leaves without annotations.
class KASUMI_THREAD_ANNOTATION(capability("mutex")) Mutex {
 public:
  void lock() KASUMI_THREAD_ANNOTATION(acquire_capability()) { mutex_.lock(); }
  void unlock() KASUMI_THREAD_ANNOTATION(release_capability()) { mutex_.unlock(); }

 private:
  std::mutex mutex_;
};

class KASUMI_THREAD_ANNOTATION(scoped_lockable) MutexLock {
 public:
  explicit MutexLock(Mutex& mutex) KASUMI_THREAD_ANNOTATION(acquire_capability(mutex)) : mutex_(mutex) {
    mutex_.lock();
  }
  ~MutexLock() KASUMI_THREAD_ANNOTATION(release_capability()) { mutex_.unlock(); }
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

 private:
  Mutex& mutex_;
};

}  // namespace kasumi
