#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <sstream>

#include "base/utc_text.hpp"
#include "pipeline/kiosk/doctor/checks.hpp"
#include "pipeline/machine/disk_probe.hpp"
#include "pipeline/machine/heat.hpp"

namespace kasumi {

namespace {

constexpr double kLowSpace_bytes = 1e9, kFullDisk_bytes = 2e8;  // bytes
constexpr double kSlowWrite_s = 1.0;
constexpr std::size_t kProbeBytes = 65536;

std::map<std::string, std::string> properties_of(const std::string& text) {
  std::map<std::string, std::string> properties;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (const auto equals = line.find('='); equals != std::string::npos)
      properties[line.substr(0, equals)] = line.substr(equals + 1);
  return properties;
}

void check_unit(const MachinePlaces& places, Findings& findings) {
  const auto text =
      places.unit_properties ? places.unit_properties() : fail(Fault{FaultKind::unsupported, "not available here"});
  if (!text) {
    findings.warn("service.unit", "systemd does not answer: " + text.error().message,
                  "without systemd nothing restarts the program when it ends or hangs");
    return;
  }
  auto properties = properties_of(*text);
  if (properties["LoadState"] != "loaded") {
    findings.warn("service.unit", "kasumi.service is not installed",
                  "install the package, or sudo cmake --install build; then sudo systemctl daemon-reload");
    return;
  }
  if (properties["ActiveState"] == "failed")
    findings.fail(
        "service.unit", "kasumi.service has failed: " + properties["Result"],
        properties["ExecMainStatus"] == "78"
            ? "its configuration is invalid: kasumi run --config FILE --check; then sudo systemctl restart kasumi"
            : "journalctl -u kasumi -b; then sudo systemctl restart kasumi");
  else if (properties["UnitFileState"] != "enabled")
    findings.warn("service.unit", "kasumi.service does not start at boot (" + properties["UnitFileState"] + ")",
                  "sudo systemctl enable kasumi");
  else
    findings.good("service.unit", "kasumi.service is " + properties["ActiveState"] + ", and starts at boot");

  const auto restarts = std::atoi(properties["NRestarts"].c_str());
  auto& restarted = restarts == 0
                        ? findings.good("service.restarts", "none since it was started")
                        : findings.warn("service.restarts", fmt::format("restarted {} times by itself", restarts),
                                        "journalctl -u kasumi -b -p warning shows why");
  restarted.values["restarts"] = restarts;

  const auto& watchdog = properties["WatchdogUSec"];
  if (watchdog.empty() || watchdog == "0" || watchdog == "infinity")
    findings.warn("watchdog.service", "systemd does not watch the render loop",
                  "WatchdogSec=20 is missing: systemctl cat kasumi shows where it was changed");
  else
    findings.good("watchdog.service", "a hanging render loop is restarted after " + watchdog);
}

void check_writing(const std::filesystem::path& folder, Findings& findings) {
  const auto probe = probe_disk(folder, kProbeBytes);
  const auto where = probe ? fmt::format("{}, as {}", folder.string(), probe->account) : std::string();
  if (!probe)
    findings.fail("disk.write", probe.error().message, "dmesg | tail");
  else if (probe->hangs)
    findings.fail("disk.write", fmt::format("{}: nothing was written in {:.0f} s", where, probe->seconds),
                  "a failing or busy disk: dmesg | tail, iotop");
  else if (probe->error == EACCES && ::geteuid() != 0)
    findings.warn("disk.write", "not tried: this user may not write " + folder.string(), "run this with sudo");
  else if (probe->error == EACCES)
    findings.fail("disk.write", where + ": may not be written", "sudo chown -R kasumi:kasumi " + folder.string());
  else if (probe->error != 0)
    findings.fail("disk.write", fmt::format("{}: cannot be written: {}", where, std::strerror(probe->error)),
                  "mount | grep ' / ' shows whether it is read-only, as with a failing memory card; dmesg | tail");
  else if (probe->seconds > kSlowWrite_s)
    findings
        .warn("disk.write", fmt::format("64 kB took {:.1f} s", probe->seconds),
              "a failing or busy disk: dmesg | tail, iotop")
        .values["seconds"] = probe->seconds;
  else
    findings.good("disk.write", fmt::format("64 kB written to disk in {:.0f} ms", probe->seconds * 1e3))
        .values["seconds"] = probe->seconds;
}

}  // namespace

void check_clock(const ClockRules& options, const ClockState& state, Utc now, Findings& findings) {
  const auto shown = utc_text(std::chrono::floor<std::chrono::seconds>(now));
  if (now < options.earliest)
    findings.fail("clock", fmt::format("the clock shows {}, which is impossible", shown),
                  "sudo timedatectl set-time ..., or set up a time server: systemctl status systemd-timesyncd");
  else if (state.synchronized)
    findings.good("clock", fmt::format("{}, synchronized", shown));
  else if (options.policy == ClockPolicy::trusted)
    findings.good("clock", fmt::format("{}, not synchronized, but trusted by [clock] policy", shown));
  else
    findings.warn(
        "clock",
        fmt::format("{}, not synchronized: {}", shown,
                    options.policy == ClockPolicy::from_sky ? "the sky camera locates the sun"
                                                            : "no building is drawn until it is synchronized"),
        "timedatectl timesync-status; sudo apt install systemd-timesyncd; without a network: a clock chip or GPS, "
        "or [clock] policy = \"from_sky\"");
}

void check_temperature(const MachinePlaces& places, Findings& findings) {
  const auto zones = read_thermal_zones(places.sys);
  const auto* closest = hottest(zones, {});
  if (!closest) {
    findings.good("temperature", "this machine has no temperature sensor");
    return;
  }
  const auto found = fmt::format("{}: {:.0f} degrees", closest->name, closest->celsius);
  const char* advice = "check fan, dust, sun on the case; the machine throttles and then switches itself off";
  auto& finding = closest->celsius >= closest->hot_celsius    ? findings.fail("temperature", found, advice)
                  : closest->celsius >= closest->warm_celsius ? findings.warn("temperature", found, advice)
                                                              : findings.good("temperature", found);
  finding.values = {
      {"celsius", closest->celsius}, {"warm_celsius", closest->warm_celsius}, {"hot_celsius", closest->hot_celsius}};
}

void check_throttling(const MachinePlaces& places, Findings& findings) {
  // Raspberry Pi's firmware: low bits for now, the same bits 16 higher for since boot.
  if (const auto reported = read_throttling_bits(places.sys)) {
    const auto bits = *reported;
    constexpr std::array kMeanings{"the supply's voltage is too low", "the CPU frequency is capped", "throttled",
                                   "near the temperature limit"};
    std::string now, past;
    for (std::size_t bit = 0; bit < kMeanings.size(); ++bit) {
      const auto add = [&](std::string& to) { to += (to.empty() ? "" : ", ") + std::string(kMeanings[bit]); };
      if (bits >> bit & 1)
        add(now);
      else if (bits >> (bit + 16) & 1)
        add(past);
    }
    const bool voltage = (bits & 0x10001) != 0;
    const char* advice = voltage ? "use a stronger supply and a shorter cable: low voltage also corrupts memory cards"
                                 : "fan, dust, sun on the case";
    if (!now.empty())
      findings.fail("throttling", "now: " + now, advice).values["bits"] = static_cast<double>(bits);
    else if (!past.empty())
      findings.warn("throttling", "since boot: " + past, advice).values["bits"] = static_cast<double>(bits);
    else
      findings.good("throttling", "none since boot").values["bits"] = 0;
    return;
  }
  double count = 0.0;
  bool reported = false;
  for (const auto& cpu : entries_of(places.sys / "devices/system/cpu", "cpu"))
    if (const auto times = number_of(cpu / "thermal_throttle/package_throttle_count")) {
      count = std::max(count, *times);
      reported = true;
    }
  if (!reported)
    findings.good("throttling", "this machine does not report it");
  else if (count > 0.0)
    findings
        .warn("throttling", fmt::format("slowed down by heat {:.0f} times since boot", count),
              "fan, dust, sun on the case")
        .values["times"] = count;
  else
    findings.good("throttling", "none since boot").values["times"] = 0;
}

void check_disk(const std::filesystem::path& folder, Findings& findings) {
  std::error_code error;
  const auto space = std::filesystem::space(folder, error);
  if (error) {
    findings.fail("disk.space", fmt::format("{}: {}", folder.string(), error.message()),
                  "the service creates /var/lib/kasumi when it starts; create another [state] folder yourself");
    return;
  }
  const double free = static_cast<double>(space.available);
  const auto found = fmt::format("{:.1f} GB free for {}", free / 1e9, folder.string());
  const char* advice = "move recordings away; sudo journalctl --vacuum-size=200M";
  auto& finding = free < kFullDisk_bytes   ? findings.fail("disk.space", found, advice)
                  : free < kLowSpace_bytes ? findings.warn("disk.space", found, advice)
                                           : findings.good("disk.space", found);
  finding.values["free_bytes"] = free;

  check_writing(folder, findings);
}

void check_watchdogs(const MachinePlaces& places, Findings& findings) {
  check_unit(places, findings);
  const char* advice =
      "the package kasumi-kiosk, or RuntimeWatchdogSec=15 below [Manager] in /etc/systemd/system.conf.d/watchdog.conf, "
      "then reboot: a machine that hangs then reboots";
  const auto devices = entries_of(places.sys / "class/watchdog", "watchdog");
  if (devices.empty()) {
    findings.warn("watchdog.machine", "this machine has no hardware watchdog (or its driver is not loaded)",
                  "modprobe softdog is better than nothing; then RuntimeWatchdogSec=15");
    return;
  }
  for (const auto& device : devices) {
    const auto identity = line_of(device / "identity");
    if (line_of(device / "state") != "active") continue;
    auto& finding =
        findings.good("watchdog.machine", fmt::format("{}: on, {} s", identity, line_of(device / "timeout")));
    if (const auto timeout = number_of(device / "timeout")) finding.values["timeout_s"] = *timeout;
    return;
  }
  findings.warn("watchdog.machine", fmt::format("{}: off", line_of(devices.front() / "identity")), advice);
}

}  // namespace kasumi
