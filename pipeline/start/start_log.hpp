// The record of starts on disk, and where this boot and this service keep it. Thread-safe.
#pragma once

#include <atomic>
#include <filesystem>
#include <memory>
#include <mutex>

#include "base/result.hpp"
#include "pipeline/start/start_record.hpp"

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
  // Reads folder/starts.json and notes this start. A record that cannot be read begins anew, one that cannot be
  // written is logged once: neither may keep anything from being shown. Without a folder nothing is counted. What
  // systemd/wait-before-start has noted for starts that do not come as far as this is forgotten.
  StartLog(const ServiceFolders& folders, const std::string& boot, double since_boot_s);

  StartRecord record() const;
  StartMode mode() const { return record().mode; }

  // What it is about to do, for the record of a start that fails.
  void doing(const std::string& what);
  void shown();  // the display takes pictures, or is known to be absent
  void well();   // also lets the unit's next failures be counted from the beginning
  void ended();  // on purpose
  // Its opening hangs. BLOCKS until that is on the disk, which is before the watchdog ends the program.
  void opening_hangs(const std::string& camera);
  void opened(const std::string& camera);  // pictures come of it

 private:
  template <class Change>
  void change(Change change);

  ServiceFolders folders_;
  mutable std::mutex mutex_;
  StartRecord record_;
  bool write_failed_ = false;
};

}  // namespace kasumi
