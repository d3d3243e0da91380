// The record of starts, and where this boot and this service keep it: at once in the runtime folder, which is memory;
// what must outlast a boot is noted on the disk behind the picture's back. Memory, too, may not answer: a machine that
// swaps to a disk that hangs. Thread-safe.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>

#include "base/thread_annotations.hpp"
#include "pipeline/kiosk/start/start_record.hpp"
#include "pipeline/kiosk/start/state_writer.hpp"

namespace kasumi {

// Where systemd lets the service keep files: folders of the unit, by the environment. Empty when started by hand:
// then nothing is counted and nothing kept.
struct ServiceFolders {
  std::filesystem::path state;    // lasts: /var/lib/kasumi
  std::filesystem::path runtime;  // until the next boot: /run/kasumi
};
ServiceFolders service_folders();

class StartLog {
 public:
  // Reads starts.json and notes this start. A record that cannot be read in time begins anew, one that cannot be
  // written is logged once: neither may delay the picture. Without a folder nothing is counted. Notes of
  // systemd/wait-before-start about starts that failed earlier than this are cleared.
  // Nothing is written to the disk before the first picture, or five seconds; but where the start before this one showed
  // nothing, BLOCKS until this one is counted, for two seconds at most.
  StartLog(const ServiceFolders& folders, const std::string& boot, double since_boot_s);

  StartRecord record() const;
  StartMode mode() const { return record().mode; }

  // What it is about to do, for the record of a start that fails.
  void doing(const std::string& what);
  void shown();  // the display takes pictures, or is known to be absent
  void well();   // also lets the unit's next failures be counted from the beginning
  void ended();  // on purpose; BLOCKS until that is on the disk, for a second at most
  // Its opening hangs. BLOCKS until that is on the disk, which is before the watchdog ends the program; for ten seconds
  // at most.
  void opening_hangs(const std::string& camera);
  void opened(const std::string& camera);  // it delivers pictures

  // Notes something else of this start on the disk, by the same rule. By hand (without a folder) at once.
  void note_too(const std::string& name, std::function<void()> job);
  // Writes something to the runtime folder. BLOCKS until it is written, for three seconds at most, and not at all while
  // the folder has not answered for so long, which is logged: then the newest job of each name is done when it answers.
  void note_in_memory(const std::string& name, std::function<void()> job);
  // Notes on the disk whatever else must outlast a boot.
  StateWriter& writer() { return writer_; }

 private:
  template <class Change>
  void change(Change change);
  Duration held() const;
  void note() KASUMI_THREAD_ANNOTATION(requires_capability(mutex_));

  ServiceFolders folders_;
  mutable Mutex mutex_;
  StartRecord record_ KASUMI_GUARDED_BY(mutex_);
  Instant hold_until_{};  // nothing is written before; the machine's clock
  std::atomic<bool> released_ = false;
  bool failed_before_ = false;  // the start before this one showed nothing
  std::shared_ptr<std::atomic<bool>> write_failed_ = std::make_shared<std::atomic<bool>>(false);
  std::atomic<bool> memory_silent_ = false;  // already logged
  StateWriter writer_, memory_;
};

}  // namespace kasumi
