// Decides whether this start succeeded: ten minutes of pictures clear the failures before it, end the probation of new
// content, and keep content that was set up by hand as a fallback for refused content.
#pragma once

#include <cstdint>
#include <filesystem>

#include "base/outside/abandonable.hpp"
#include "pipeline/kiosk/appliance/mailboxes.hpp"
#include "pipeline/kiosk/content/probation.hpp"
#include "pipeline/kiosk/start/start_log.hpp"

namespace kasumi {

struct ProvingRecords {
  StartLog* starts = nullptr;         // null: nothing is counted
  std::filesystem::path kept_folder;  // of the content; empty: none is kept
};

// Where content comes from, and what judges it.
struct ProvingPlaces {
  ContentPlace content;
  std::optional<std::filesystem::path> status_file;  // which the doctor reads; empty: it is not asked
  std::function<void()> reload;
};

class ProvingLoop {
 public:
  ProvingLoop(ContentPtr content, ProvingRecords options, ProvingPlaces places, Clock& clock, Mailboxes& mailboxes);
  // Returns when to be called again. BLOCKS for as long as the disk takes to keep the content.
  Instant step();

 private:
  // Time during which something went on; what stands still proves nothing.
  struct Proof {
    std::uint64_t last = 0;
    Duration lasted{};
    std::optional<Duration> since{};  // the count last grew
    // Whether it goes on: the count grew, or did so less than `patience` ago.
    bool advance(std::uint64_t count, Duration by, Duration patience = {});
  };
  void keep();
  Probation::FailingChecks ask_doctor(Duration passed);

  ContentPtr content_;
  ProvingRecords options_;
  std::optional<std::filesystem::path> status_file_;
  Clock& clock_;
  Mailboxes& mailboxes_;
  Probation probation_;
  OneAtATime<Result<std::string>> reading_;
  std::string status_before_;
  Instant stepped_;
  Proof alive_, scene_, camera_;
  bool shown_ = false, well_ = false;
  Instant keep_at_{};
  bool kept_ = false, keeping_failed_ = false;
};

}  // namespace kasumi
