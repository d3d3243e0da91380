#include "history/history_keeper.hpp"

namespace kasumi {

void HistoryKeeper::add(const std::filesystem::path& file, const HistoryLine& minute) {
  const MutexLock lock(mutex_);
  waiting_.push_back({file, minute});
  if (waiting_.size() > 60) waiting_.pop_front();
}

std::optional<HistoryKeeper::Minute> HistoryKeeper::next() {
  const MutexLock lock(mutex_);
  if (waiting_.empty()) return std::nullopt;
  auto minute = std::move(waiting_.front());
  waiting_.pop_front();
  return minute;
}

Result<> HistoryKeeper::write() {
  while (auto minute = next()) {
    if (minute->file != file_) ring_.reset();
    file_ = minute->file;
    Result<> kept;
    if (!ring_) {
      auto ring = HistoryRing::open(file_);
      if (ring)
        ring_ = std::move(*ring);
      else
        kept = fail(ring.error());
    }
    if (ring_) kept = ring_->append(minute->line);
    if (kept) continue;
    ring_.reset();
    const MutexLock lock(mutex_);
    waiting_.push_front(std::move(*minute));
    return kept;
  }
  return {};
}

}  // namespace kasumi
