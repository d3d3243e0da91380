#include <csignal>
#include <cstdlib>
#include <thread>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "base/files.hpp"
#include "pipeline/command.hpp"
#include "pipeline/log_lines.hpp"
#include "pipeline/machine/running_appliance.hpp"

namespace kasumi {

namespace {

using namespace std::chrono_literals;

constexpr auto kLookInterval = 100ms;

struct ReloadArguments {
  std::string status;
  double seconds = 50.0;  // less than systemd allows
};

std::filesystem::path status_file_of(const ReloadArguments& arguments) {
  if (!arguments.status.empty()) return arguments.status;
  if (const char* folder = std::getenv("RUNTIME_DIRECTORY"); folder && *folder)
    return std::filesystem::path(folder) / "status.json";
  return kServiceStatusFile;
}

// Of a reload that began after `asked`, on the clock that the machine's processes share. Empty: none has ended yet.
std::optional<std::vector<std::string>> problems_since(Instant asked, const std::string& status) {
  const auto json = nlohmann::json::parse(status, nullptr, false);
  const auto content = json.is_object() ? json.value("content", nlohmann::json()) : nlohmann::json();
  if (!content.is_object() || !content.contains("reload_began_s") || !content["reload_began_s"].is_number())
    return std::nullopt;
  if (content["reload_began_s"].get<double>() < to_seconds(asked.time_since_epoch())) return std::nullopt;
  return content.value("problems", std::vector<std::string>());
}

Result<int> reload(const ReloadArguments& arguments) {
  const auto file = status_file_of(arguments);
  const auto running = find_running_appliance(file);
  if (!running)
    return fail(FaultKind::disconnected, "{}: no appliance is running: sudo systemctl start kasumi", file.string());
  SystemClock clock;
  const Instant asked = clock.now();
  if (::kill(running->pid, SIGHUP) != 0)
    return fail(FaultKind::io, "process {} does not let itself be asked: run this with sudo", running->pid);
  while (clock.now() - asked < from_seconds(arguments.seconds)) {
    std::this_thread::sleep_for(kLookInterval);
    const auto now = find_running_appliance(file);
    if (!now || now->pid != running->pid)
      return fail(FaultKind::disconnected, "the appliance ended while it was to reload: journalctl -u kasumi");
    const auto problems = problems_since(asked, now->status);
    if (!problems) continue;
    if (problems->empty()) {
      print_success("reloaded");
      return 0;
    }
    print_error(fmt::format("the new content is refused, the old stays:\n  {}", fmt::join(*problems, "\n  ")));
    return 1;
  }
  return fail(FaultKind::timeout, "no answer within {:g} s; `content` of {} will have it", arguments.seconds,
              file.string());
}

}  // namespace

void add_reload_command(CLI::App& app, Action& action) {
  auto* command =
      app.add_subcommand("reload", "Let the running kiosk load its configuration and content anew, and wait");
  auto arguments = std::make_shared<ReloadArguments>();
  command->add_option(
      "--status", arguments->status,
      "The kiosk's status file (default: $RUNTIME_DIRECTORY/status.json, else /run/kasumi/status.json)");
  command->add_option("--seconds", arguments->seconds, "How long to wait for the answer")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  command->callback([arguments, &action] { action = [arguments] { return reload(*arguments); }; });
}

}  // namespace kasumi
