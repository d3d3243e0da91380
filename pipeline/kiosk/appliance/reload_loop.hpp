// Reloading in two phases: everything is read and prepared, on the GPU too, before any loop uses any of it. Then all
// loops adopt the new content, or none does. An era's content is prepared the same way when its time has come; it was
// read with all the others, and only the picture's loop and the status learn of it.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>

#include "base/outside/abandonable.hpp"
#include "pipeline/kiosk/appliance/status_mailbox.hpp"
#include "pipeline/kiosk/content/generations.hpp"
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
  ReloadLoop(ContentPlace place, ContentPtr content, Clock& clock, Notifier& notifier, Mailboxes& mailboxes,
             Probes probes);

  // Any thread. What is being read is abandoned for it; where the new content is being prepared already, it follows.
  void ask();
  // BLOCKS for a second at most. Returns when to be called again unless the mailbox's bell rings.
  Instant step();

 private:
  enum class Change { reload, era };
  void begin();
  void take_content();
  void change_era();
  void leave_era();
  void order(ContentPtr content, Change change);
  void take_answer();
  void adopt();
  void adopt_era();
  void refuse_era(const std::string& problems);
  void forget_refused_era();
  void refuse(const std::string& problems);
  void end(std::vector<std::string> problems);
  void publish(std::string doing);

  ContentPlace place_;
  ContentPtr content_;                 // in use
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
    Change change = Change::reload;
  };
  struct Reading {
    Abandonable<Result<ContentPtr>> content;
    Instant patient_until, until;  // a newer request waits for the first, all end with the second
  };
  std::optional<Reading> reading_;  // in a thread of its own: a disk may never answer
  std::optional<Waiting> waiting_;  // for the render loop's answer
  std::uint64_t orders_ = 0;
  Instant began_{};
  std::optional<std::size_t> refused_era_;  // the last
  Instant era_again_;                       // when it is tried again
  ReloadStatus status_;
};

}  // namespace kasumi
