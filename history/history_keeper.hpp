// Minutes on their way to the ring on the disk: handed over by one thread, written by another, since a disk may hang.
#pragma once

#include <deque>
#include <filesystem>
#include <optional>

#include "base/thread_annotations.hpp"
#include "history/history_ring.hpp"

namespace kasumi {

class HistoryKeeper {
 public:
  // Thread-safe. While nothing can be written, the newest hour is kept.
  void add(const std::filesystem::path& file, const HistoryLine& minute);
  // BLOCKS for as long as the disk takes; one thread alone. Error (io): what was not written is tried again next time.
  Result<> write();

 private:
  struct Minute {
    std::filesystem::path file;
    HistoryLine line;
  };
  std::optional<Minute> next();

  Mutex mutex_;
  std::deque<Minute> waiting_ KASUMI_GUARDED_BY(mutex_);
  std::filesystem::path file_;  // of the ring
  std::optional<HistoryRing> ring_;
};

}  // namespace kasumi
