// Answers `kasumi snapshot`, and kasumi-report where that is allowed: hands their requests to the main thread, blurs what
// that one gives, and sends it.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <optional>

#include "base/outside/abandonable.hpp"
#include "base/unique_fd.hpp"
#include "pipeline/kiosk/appliance/mailboxes.hpp"

namespace kasumi {

// One caller at a time, `kasumi snapshot` before the reporter. A caller that is slow, silent or sends nonsense is
// disconnected; nothing is read from the reporter. It gets at most one picture a minute.
class SnapshotServer {
 public:
  // `folder`: where the socket is made. Without it, or where it cannot be made, which is logged, there are no answers.
  // BLOCKS for at most a quarter of a second; a folder that does not answer is asked again by step().
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
  // One of the two sockets.
  struct Door {
    std::size_t at;                  // in `listening_`
    const char* lost;                // logged where it cannot be opened
    std::filesystem::path path{};    // empty: it stays shut
    bool failed = false;             // which was logged
    Instant again = Instant::min();  // after a failure
    OneAtATime<Result<UniqueFd>> opening{};
  };
  void open(Door& door, std::function<Result<UniqueFd>()> work);
  void shut(Door& door);
  void offer_command();
  void offer_page();
  void answer(const UniqueFd& caller);
  void answer_page(const UniqueFd& caller);
  std::optional<Snapshot> take(SnapshotKind kind);

  std::function<void(SnapshotKind)> ask_;
  SnapshotMailbox& answers_;
  const Clock& clock_;
  static constexpr std::size_t kCommand = 0, kPage = 1;  // places of the two
  Door command_{kCommand, "kasumi snapshot will not be answered"};
  Door page_{kPage, "kasumi-report will get no picture of the screen"};
  std::array<UniqueFd, 2> listening_;  // either may be empty
  Instant next_page_ = Instant::min();
};

}  // namespace kasumi
