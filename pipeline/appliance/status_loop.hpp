// The status loop: writes the appliance's status and saves the air for the next start.
#pragma once

#include <filesystem>
#include <optional>

#include "pipeline/appliance/status.hpp"
#include "pipeline/machine/notifier.hpp"

namespace kasumi {

struct StatusOptions {
  std::optional<std::filesystem::path> file;         // status.json
  bool stats = false;                                // log latency and copies every minute
  Duration save_interval = std::chrono::minutes(5);  // of the air
};

class StatusLoop {
 public:
  StatusLoop(ContentPtr content, StatusOptions options, Clock& clock, Notifier& notifier, Mailboxes& mailboxes);
  // BLOCKS for as long as the disk takes. Call it about once a second.
  void step();
  void finish();  // writes and saves one last time
  const Status& status() const { return status_; }

 private:
  void gather();
  void write_status();
  void save_air();

  ContentPtr content_;
  StatusOptions options_;
  Clock& clock_;
  Notifier& notifier_;
  Mailboxes& mailboxes_;
  Status status_;
  std::string line_;
  bool write_failing_ = false, save_failing_ = false;  // already logged
  Instant saved_, stats_at_;
};

}  // namespace kasumi
