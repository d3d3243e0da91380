#include "pipeline/machine/ask_to_reload.hpp"

#include <csignal>
#include <cstdlib>
#include <optional>
#include <thread>

#include <nlohmann/json.hpp>

#include "base/outside/json_depth.hpp"
#include "base/outside/json_text.hpp"
#include "pipeline/machine/running_appliance.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr auto kLookInterval = 100ms;

// Of a reload that began after `asked`, on the clock that the machine's processes share. Empty: none has ended yet.
std::optional<std::vector<std::string>> problems_since(Instant asked, const std::string& status) {
  const auto json = parse_json(modest_json(status));
  const auto content = json.is_object() ? json.value("content", nlohmann::json()) : nlohmann::json();
  if (!content.is_object() || !content.contains("reload_began_s") || !content["reload_began_s"].is_number())
    return std::nullopt;
  if (content["reload_began_s"].get<double>() < to_seconds(asked.time_since_epoch())) return std::nullopt;
  return content.value("problems", std::vector<std::string>());
}

}  // namespace

std::filesystem::path usual_status_file() {
  if (const char* folder = std::getenv("RUNTIME_DIRECTORY"); folder && *folder)
    return std::filesystem::path(folder) / "status.json";
  return kServiceStatusFile;
}

Result<std::vector<std::string>> ask_to_reload(const std::filesystem::path& status_file, Duration longest) {
  const auto running = find_running_appliance(status_file);
  if (!running)
    return fail(FaultKind::disconnected, "{}: no appliance is running: sudo systemctl start kasumi",
                status_file.string());
  SystemClock clock;
  const Instant asked = clock.now();
  if (::kill(running->pid, SIGHUP) != 0)
    return fail(FaultKind::io, "process {} does not let itself be asked: run this with sudo", running->pid);
  while (clock.now() - asked < longest) {
    std::this_thread::sleep_for(kLookInterval);
    const auto now = find_running_appliance(status_file);
    if (!now || now->pid != running->pid)
      return fail(FaultKind::disconnected, "the appliance ended while it was to reload: journalctl -u kasumi");
    if (auto problems = problems_since(asked, now->status)) return std::move(*problems);
  }
  return fail(FaultKind::timeout, "no answer within {:g} s; `content` of {} will have it", to_seconds(longest),
              status_file.string());
}

}  // namespace kasumi
