// Answers `kasumi snapshot`, and kasumi-report where that is allowed: hands their requests to the main thread, blurs what
// that one gives, and sends it.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>

#include "base/unique_fd.hpp"
#include "pipeline/kiosk/appliance/mailboxes.hpp"

namespace kasumi {

// One caller at a time, `kasumi snapshot` before the reporter. A caller that is slow, silent or sends nonsense is
// disconnected; nothing is read from the reporter. It gets at most one picture a minute.
class SnapshotServer {
 public:
  // `folder`: where the socket is made. Without it, or where it cannot be made, which is logged, there are no answers.
  // `ask` forwards the request to the render loop, which puts the answer into `answers` and states there whether the
  // reporter may ask. Its socket exists only while it may.
  SnapshotServer(const std::optional<std::filesystem::path>& folder, std::function<void(SnapshotKind)> ask,
                 SnapshotMailbox& answers, const Clock& clock);
  ~SnapshotServer();
  SnapshotServer(const SnapshotServer&) = delete;
  SnapshotServer& operator=(const SnapshotServer&) = delete;

  // Serves the next caller. BLOCKS for at most a quarter of a second where none comes, else for at most the deadlines
  // of request, picture and answer, 1, 8 and 2 s; ringing the mailbox's bell ends the second.
  void step();

 private:
  void offer_page();
  void answer(const UniqueFd& caller);
  void answer_page(const UniqueFd& caller);
  std::optional<Snapshot> take(SnapshotKind kind);

  std::function<void(SnapshotKind)> ask_;
  SnapshotMailbox& answers_;
  const Clock& clock_;
  std::filesystem::path path_, page_path_;
  std::array<UniqueFd, 2> listening_;  // for `kasumi snapshot` and for the reporter; either may be empty
  bool page_failed_ = false;           // its socket cannot be made, which was logged
  Instant next_page_ = Instant::min();
};

}  // namespace kasumi
