#include "pipeline/machine/running_appliance.hpp"

#include <chrono>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/files.hpp"

namespace kasumi {

std::optional<RunningAppliance> find_running_appliance(const std::filesystem::path& status_file,
                                                       const std::filesystem::path& proc) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(status_file, error)) return std::nullopt;
  RunningAppliance running;
  running.status = read_text_file(status_file).value_or("");
  const auto json = nlohmann::json::parse(running.status, nullptr, false);
  if (!json.is_object() || !json.contains("pid") || !json["pid"].is_number_integer()) return std::nullopt;
  running.pid = json["pid"].get<int>();
  // The process id may belong to another program by now.
  const auto name = read_text_file(proc / std::to_string(running.pid) / "comm");
  if (!name || *name != "kasumi\n") return std::nullopt;
  const auto written = std::filesystem::last_write_time(status_file, error);
  if (!error)
    running.age_s = std::chrono::duration<double>(std::filesystem::file_time_type::clock::now() - written).count();
  return running;
}

}  // namespace kasumi
