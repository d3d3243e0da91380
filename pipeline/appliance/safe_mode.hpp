// Safe mode: the still picture and words, when boot after boot has come to nothing. Not the appliance: no cameras, no
// scene, no state, none of its loops; whatever made it fail is left alone. It answers `kasumi snapshot`, since whoever
// is to mend it may sit far away.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "pipeline/appliance/snapshot_desk.hpp"
#include "pipeline/appliance/snapshot_server.hpp"
#include "pipeline/appliance/status_loop.hpp"
#include "pipeline/machine/devices.hpp"
#include "pipeline/machine/watchdog.hpp"
#include "pipeline/stage/still_picture.hpp"
#include "pipeline/stage/words.hpp"
#include "pipeline/start/start_log.hpp"

namespace kasumi {

// Belongs to one thread, but for snapshot(), which has one of its own.
class SafeMode {
 public:
  // All references must outlive it.
  SafeMode(ContentPtr content, Devices& devices, Clock& clock, Notifier& notifier, StartLog& starts,
           std::optional<std::filesystem::path> status_file);

  // Shows, writes the status, and returns when to be called again. BLOCKS for a quarter of a second at most, but while
  // a display is being opened.
  Instant step();
  void finish();  // closes the display, writes the status one last time
  // Its time is up: everything is to be tried again.
  bool is_over() const { return clock_.now() - began_ >= lasts_; }
  const Status& status() const { return status_; }
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
Result<> run_safe_mode(const std::filesystem::path& config_file, StartLog& starts,
                       std::optional<std::filesystem::path> status_file);

}  // namespace kasumi
