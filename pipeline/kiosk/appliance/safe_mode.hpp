// Safe mode: the still picture and words, after several boots have failed, or when no content can be shown. It is not
// the appliance: it uses no cameras, scene, state or loops, any of which may have caused the failure. It answers
// `kasumi snapshot`, since the operator may be far away.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "pipeline/kiosk/appliance/snapshot_desk.hpp"
#include "pipeline/kiosk/appliance/snapshot_server.hpp"
#include "pipeline/kiosk/appliance/status_loop.hpp"
#include "pipeline/kiosk/start/safe_content.hpp"
#include "pipeline/kiosk/start/start_log.hpp"
#include "pipeline/machine/devices.hpp"
#include "pipeline/machine/watchdog.hpp"
#include "pipeline/show/stage/still_picture.hpp"
#include "pipeline/show/stage/words.hpp"

namespace kasumi {

// The reason for safe mode, for the status.
struct SafeReason {
  Trouble trouble = Trouble::safe_mode;
  std::vector<std::string> refused{};  // what is wrong with the content
};

// Belongs to one thread, but for snapshot(), which has one of its own.
class SafeMode {
 public:
  // All references must outlive it.
  SafeMode(ContentPtr content, Devices& devices, Clock& clock, Notifier& notifier, StartLog& starts,
           std::optional<std::filesystem::path> status_file, SafeReason reason = {});

  // Shows, writes the status, and returns when to be called again. BLOCKS for a quarter of a second at most, but while
  // a display is being opened.
  Instant step();
  // Closes the display, writes the status one last time, with this reason.
  void finish(Trouble trouble = Trouble::stopped);
  // Its time is up: everything is to be tried again.
  bool is_over() const { return clock_.now() - began_ >= lasts_; }
  const Status& status() const { return status_; }
  // The result of a search for content that began then; no problems: content was found.
  void tried(Instant began, std::vector<std::string> problems);
  Display* display() { return open_ ? open_->display.get() : nullptr; }
  SnapshotServer& snapshot() { return server_; }
  Bell& snapshot_bell() { return answers_.bell; }

 private:
  struct Open {
    std::unique_ptr<Display> display;
    StillPicture still;
    Words caption, message;
  };
  void try_open();
  Result<> show();
  std::string message() const;
  Snapshot snapshot_facts() const;
  void prove();
  void write_status();

  ContentPtr content_;
  Devices& devices_;
  Clock& clock_;
  Notifier& notifier_;
  StartLog& starts_;
  std::optional<std::filesystem::path> status_file_;
  Watchdog watchdog_;
  Status status_;
  std::optional<Open> open_;
  Instant began_;
  Duration lasts_;
  Instant try_at_;
  std::optional<Instant> shown_at_, timeouts_since_, status_at_;
  bool proven_ = false;

  LatestSlot<SnapshotKind> wanted_;
  SnapshotMailbox answers_;
  SnapshotDesk desk_{answers_};
  SnapshotServer server_;
  std::string shown_message_;
};

// Runs it until SIGTERM or SIGINT; SIGHUP, or its time, ends it so that the service manager starts everything again.
// Call it before any other thread exists.
Result<> run_safe_mode(const FindConfiguration& find, StartLog& starts,
                       std::optional<std::filesystem::path> status_file);

// Runs it where no content can be shown, until there is some: `try_again` is called behind the picture, in a thread of
// its own that may never come back, after 15 s, 30 s, 1 min .. 5 min and at SIGHUP. Null: it was ended by SIGTERM or
// SIGINT. As above in all else.
ContentPtr run_without_content(const FindConfiguration& find, StartLog& starts,
                               std::optional<std::filesystem::path> status_file, std::vector<std::string> refused,
                               const std::function<Result<ContentPtr>()>& try_again);

}  // namespace kasumi
