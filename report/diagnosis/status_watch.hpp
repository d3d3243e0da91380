// status.json, looked at again and again by a program that cannot rely on whoever writes it.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "report/diagnosis/reported_status.hpp"

namespace kasumi::report {

enum class Contact {
  heard,       // the appliance tells its status
  silent,      // it has not told it for longer than kSilent: it hangs, or was killed
  stopped,     // it was stopped on purpose within kStopPassesBy, and is silent or absent since
  absent,      // there is none: it is not running
  unreadable,  // what lies there is no status
};
std::string_view name_of(Contact contact);

// The appliance writes once a second, and a disk may be slow.
constexpr Duration kSilent = std::chrono::seconds(15);
// The same once its process has gone: one that follows has begun to write by then.
constexpr Duration kGone = std::chrono::seconds(5);
// A stop by the service manager, or somebody: an update, a reboot.
constexpr Duration kStopPassesBy = std::chrono::minutes(10);

struct Heard {
  Contact contact = Contact::absent;
  std::optional<ReportedStatus> status;  // only when heard
  std::string why;                       // why not
  Duration silent{};                     // since it was written
};

// The whole text of a file of at most `most_bytes`, which must be a regular one: no link, pipe or device, which would lead
// elsewhere or never end. Errors: bad_input (absent, another kind, larger), io.
Result<std::string> read_distrusted_file(const std::filesystem::path& path, std::size_t most_bytes);

// What this machine says of time and processes, so that a first look already knows how old a status is. Tests substitute
// their own.
struct ThisMachine {
  std::string boot;  // empty: unknown, as under the reporter's unit, which sees processes in /proc and nothing else
  std::function<double()> since_boot_s;
  std::function<bool(double pid)> runs;
};
ThisMachine this_machine();

class StatusWatch {
 public:
  StatusWatch(std::filesystem::path file, Clock& clock, ThisMachine machine = this_machine())
      : file_(std::move(file)), clock_(clock), machine_(std::move(machine)) {}
  // BLOCKS for as long as reading a small file takes. Call it about once a second.
  Heard look();

 private:
  std::filesystem::path file_;
  Clock& clock_;
  // Since it was written, by the status itself and by what was seen of it; and whether whoever wrote it has gone.
  struct Age {
    Duration silent{};
    bool gone = false;
  };
  Age age_of(const ReportedStatus& status) const;

  ThisMachine machine_;
  std::string text_;  // as it was last
  std::optional<Instant> changed_;
  std::optional<Instant> heard_at_;  // last
};

}  // namespace kasumi::report
