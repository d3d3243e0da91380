#include "pipeline/machine/running_appliance.hpp"

#include <chrono>
#include <csignal>
#include <cstdlib>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"

namespace kasumi {

namespace {

// In the commands of a unit (ExecReload=) systemd names its main process. There /proc shows no other process: with
// PrivateUsers= each has a user namespace of its own, and ProtectProc=invisible hides those of other namespaces.
bool is_named_by_systemd(int pid) {
  const char* named = std::getenv("MAINPID");
  return named && named == std::to_string(pid) && ::kill(pid, 0) == 0;
}

}  // namespace

std::optional<RunningAppliance> find_running_appliance(const std::filesystem::path& status_file,
                                                       const std::filesystem::path& proc) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(status_file, error)) return std::nullopt;
  RunningAppliance running;
  running.status = read_text_file(status_file, kSmallFile).value_or("");
  const auto json = parse_json(modest_json(running.status));
  if (!json.is_object() || !json.contains("pid") || !json["pid"].is_number_integer()) return std::nullopt;
  running.pid = json["pid"].get<int>();
  // The process id may belong to another program by now.
  const auto name = read_text_file(proc / std::to_string(running.pid) / "comm");
  if (name.value_or("") != "kasumi\n" && !is_named_by_systemd(running.pid)) return std::nullopt;
  const auto written = std::filesystem::last_write_time(status_file, error);
  if (!error)
    running.age_s = std::chrono::duration<double>(std::filesystem::file_time_type::clock::now() - written).count();
  return running;
}

}  // namespace kasumi
