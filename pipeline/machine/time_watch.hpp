// What this machine knows about its clock, and what is remembered of that over a restart of the service.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "pipeline/site/config/time_trust.hpp"

namespace kasumi {

// Where to ask. Tests substitute their own.
struct TimeSources {
  // The kernel whether its clock is synchronized; empty: not permitted, as in the service (ProtectClock=).
  std::function<std::optional<bool>()> kernel;
  // systemd-timesyncd writes it anew at each synchronization.
  std::filesystem::path timesyncd = "/run/systemd/timesync/synchronized";
  bool ask_timedated = true;  // over the system bus: it knows of chrony's and others' work, too
};
TimeSources machine_time_sources();

// Notices when the clock is set, by a timer that the kernel then cancels. None of the sources is waited for.
std::unique_ptr<TimeWatch> watch_time(TimeSources sources = machine_time_sources());

// The machine's clock against the time since its boot: only setting the clock moves one against the other.
struct BootTime {
  std::string id;
  std::function<double()> since_s;
  std::function<Utc()> utc;
};
BootTime this_boot_time();

// Passes on what `watch` reads, and keeps in `file`, below /run, that the clock was synchronized in this boot and not
// set since: a restart of the service must not hide the building because the time server is unreachable by then.
// `file` empty: nothing is kept.
std::unique_ptr<TimeWatch> remember_trust(std::unique_ptr<TimeWatch> watch, std::filesystem::path file,
                                          BootTime boot = this_boot_time());

}  // namespace kasumi
