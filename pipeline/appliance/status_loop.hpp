// The status thread: writes down how the appliance is, and keeps the air for the next start.
#pragma once

#include <filesystem>
#include <optional>

#include "pipeline/appliance/status.hpp"
#include "pipeline/machine/notifier.hpp"

namespace kasumi {

struct StatusOptions {
  std::optional<std::filesystem::path> file;         // status.json
  bool stats = false;                                // latency and copies into the log, every minute
  Duration save_interval = std::chrono::minutes(5);  // of the air
};

class StatusLoop {
 public:
  StatusLoop(ContentPtr content, StatusOptions options, Clock& clock, Notifier& notifier, Mailboxes& mailboxes);
  // BLOCKS as long as the disk takes. To be called about once a second.
  void step();
  void finish();  // the last of each, for good
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
  bool write_failing_ = false, save_failing_ = false;  // and said so in the log
  Instant saved_, stats_at_;
};

}  // namespace kasumi
