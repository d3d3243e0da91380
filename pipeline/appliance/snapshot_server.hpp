// Answers `kasumi snapshot`: hands its requests to the main thread, blurs what that one gives, and sends it.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "base/unique_fd.hpp"
#include "pipeline/appliance/mailboxes.hpp"

namespace kasumi {

// One caller at a time. A caller that is slow, silent or sends nonsense is hung up on.
class SnapshotServer {
 public:
  // `folder`: where the socket is made. Without it, or where it cannot be made, which is logged, nobody is answered.
  // `ask` asks who draws, who puts the answer into `answers`.
  SnapshotServer(const std::optional<std::filesystem::path>& folder, std::function<void(SnapshotKind)> ask,
                 SnapshotMailbox& answers);
  ~SnapshotServer();
  SnapshotServer(const SnapshotServer&) = delete;
  SnapshotServer& operator=(const SnapshotServer&) = delete;

  // Serves the next caller. BLOCKS for at most a quarter of a second where none comes, else for at most the deadlines
  // of request, picture and answer, 1, 8 and 2 s; ringing the mailbox's bell ends the second.
  void step();

 private:
  void answer(const UniqueFd& caller);

  std::function<void(SnapshotKind)> ask_;
  SnapshotMailbox& answers_;
  std::filesystem::path path_;
  UniqueFd listening_;
};

}  // namespace kasumi
