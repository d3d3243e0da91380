#include <cstdlib>

#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "pipeline/appliance/threads.hpp"
#include "pipeline/command.hpp"
#include "pipeline/config/sighting.hpp"

namespace kasumi {

namespace {

constexpr int kBadConfiguration = 78;  // EX_CONFIG: the unit does not restart it until a person has fixed the file

struct RunArguments {
  std::string config;
  std::string status;
  bool stats = false;
  bool check = false;
};

std::optional<std::filesystem::path> status_file(const std::string& given) {
  if (!given.empty()) return given;
  if (const char* folder = std::getenv("RUNTIME_DIRECTORY"); folder && *folder)
    return std::filesystem::path(folder) / "status.json";
  return std::nullopt;
}

Result<int> run(const RunArguments& arguments) {
  auto content = read_content(arguments.config);
  if (!content) {
    fmt::print(stderr, "kasumi: the configuration is invalid:\n{}\n", content.error().message);
    return kBadConfiguration;
  }
  const auto sighting = sight_object((*content)->config.installation, (*content)->model.bounds());
  spdlog::log(sighting.in_picture() ? spdlog::level::info : spdlog::level::warn, "{}", sighting.message);
  if (arguments.check) {
    if (const auto summary = calibration_summary((*content)->config.installation, arguments.config); !summary.empty())
      fmt::print("{}\n", summary);
    fmt::print("{}: configuration is valid\n", arguments.config);
    return 0;
  }
  const auto ended = run_appliance(arguments.config, std::move(*content),
                                   {.file = status_file(arguments.status), .stats = arguments.stats});
  if (!ended) return fail(ended.error());
  return 0;
}

}  // namespace

void add_run_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("run", "Run the kiosk: two live cameras, a display, until SIGTERM");
  auto arguments = std::make_shared<RunArguments>();
  command->add_option("--config", arguments->config, "kasumi.toml")->required();
  command->add_option("--status", arguments->status,
                      "Write the status to FILE every second (default: "
                      "$RUNTIME_DIRECTORY/status.json)");
  command->add_flag("--stats", arguments->stats,
                    "Log capture-to-flip latency, copies and drops every minute, and at "
                    "the end");
  command->add_flag("--check", arguments->check, "Only read configuration and content, and report every problem");
  command->callback([arguments, &action] { action = [arguments] { return run(*arguments); }; });
}

}  // namespace kasumi
