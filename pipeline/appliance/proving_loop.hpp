// Whether this start has come well: ten minutes of pictures forgive the failures before it, and let the content that
// was shown be kept for a day on which another one is refused.
#pragma once

#include <cstdint>
#include <filesystem>

#include "pipeline/appliance/mailboxes.hpp"
#include "pipeline/start/start_log.hpp"

namespace kasumi {

struct ProvingOptions {
  StartLog* starts = nullptr;         // null: nothing is counted
  std::filesystem::path kept_folder;  // of the content; empty: none is kept
};

class ProvingLoop {
 public:
  ProvingLoop(ContentPtr content, ProvingOptions options, Clock& clock, Mailboxes& mailboxes);
  // Returns when to be called again. BLOCKS for as long as the disk takes to keep the content.
  Instant step();

 private:
  // Time during which something went on; what stands still proves nothing.
  struct Proof {
    std::uint64_t last = 0;
    Duration lasted{};
    bool advance(std::uint64_t count, Duration by);
  };
  void keep();

  ContentPtr content_;
  ProvingOptions options_;
  Clock& clock_;
  Mailboxes& mailboxes_;
  Instant stepped_;
  Proof alive_, scene_;
  bool shown_ = false, well_ = false;
  Instant keep_at_{};
  bool kept_ = false, keeping_failed_ = false;
};

}  // namespace kasumi
