// Reloading in two phases: everything is read and prepared, on the GPU too, before anybody uses any of it. Then all
// loops adopt the new content, or none does.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>

#include "pipeline/appliance/status_mailbox.hpp"
#include "pipeline/content/generations.hpp"
#include "pipeline/machine/notifier.hpp"

namespace kasumi {

// Whether content can be drawn, found out without a display: see try_drawing(). Replaced in tests.
using TryDrawing = std::function<Result<>(const ContentPtr&, const std::shared_ptr<const PreparedStage>&)>;

// Bytes that may still be taken; empty: not known. See memory_left().
using MemoryLeft = std::function<std::optional<std::uint64_t>()>;

class ReloadLoop {
 public:
  // Of the machine where they are empty.
  struct Probes {
    TryDrawing try_drawing;
    MemoryLeft memory_left;
  };
  ReloadLoop(ContentPlace place, Clock& clock, Notifier& notifier, Mailboxes& mailboxes, Probes probes);

  // Any thread. While one is under way another follows it.
  void ask();
  // BLOCKS for the seconds that reading takes. Returns when to be called again unless the mailbox's bell rings.
  Instant step();

 private:
  void begin();
  void order(ContentPtr content);
  void take_answer();
  void adopt();
  void refuse(const std::string& problems);
  void end(std::vector<std::string> problems);
  void publish(std::string doing);

  ContentPlace place_;
  std::filesystem::path config_file_;  // of the reload under way or the last one
  Clock& clock_;
  Notifier& notifier_;
  Mailboxes& mailboxes_;
  Probes probes_;
  std::atomic<bool> asked_ = false;
  struct Waiting {
    ContentPtr content;
    std::shared_ptr<const PreparedStage> prepared;
    Instant until;
  };
  std::optional<Waiting> waiting_;  // for the render loop's answer
  std::uint64_t orders_ = 0;
  Instant began_{};
  ReloadStatus status_;
};

}  // namespace kasumi
