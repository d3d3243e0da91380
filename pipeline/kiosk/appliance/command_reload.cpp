#include <CLI/CLI.hpp>

#include "pipeline/command.hpp"
#include "pipeline/log_lines.hpp"
#include "pipeline/machine/ask_to_reload.hpp"

namespace kasumi {

namespace {

struct ReloadArguments {
  std::string status;
  double seconds = 50.0;  // less than systemd allows
};

Result<int> reload(const ReloadArguments& arguments) {
  const auto file = arguments.status.empty() ? usual_status_file() : std::filesystem::path(arguments.status);
  const auto problems = ask_to_reload(file, from_seconds(arguments.seconds));
  if (!problems) return fail(problems.error());
  if (problems->empty()) {
    print_success("reloaded");
    return 0;
  }
  print_error(fmt::format("the new content is refused, the old stays:\n  {}", fmt::join(*problems, "\n  ")));
  return 1;
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
