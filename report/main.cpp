// kasumi-report <command>: reports the kiosk's state over the network. docs/fleet.md shows what it can do.
#include <atomic>
#include <csignal>
#include <exception>
#include <functional>
#include <iostream>
#include <sstream>

#include <fmt/format.h>
#include <systemd/sd-daemon.h>
#include <CLI/CLI.hpp>

#include "base/manual/finite_options.hpp"
#include "base/manual/manual.hpp"
#include "report/diagnosis/diagnosis.hpp"
#include "report/page/tokens.hpp"
#include "report/reporter.hpp"
#include "report/show.hpp"
#include "report/trial.hpp"

namespace {

using namespace kasumi;
using namespace kasumi::report;

constexpr int kFailed = 1, kBadInput = 2;  // exit codes, as of kasumi
constexpr int kBadConfiguration = 78;      // EX_CONFIG: the service manager does not start it again
constexpr const char* kConfigFile = "/etc/kasumi/report.toml";  // where the package installs it
constexpr const char* kStatusFile = "/run/kasumi/status.json";  // where kasumi.service writes it

using Action = std::function<Result<int>()>;

void add_show_command(CLI::App& app, Action& action) {
  struct Arguments {
    std::string status = kStatusFile, language = "en";
  };
  auto* command = app.add_subcommand("show", "What visitors see now, what is wrong, and what to do about it");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("--status", arguments->status, "The appliance's status file")->capture_default_str();
  command->add_option("--language", arguments->language, language_codes())->capture_default_str();
  command->callback([arguments, &action] {
    action = [arguments]() -> Result<int> {
      const auto language = parse_language(arguments->language);
      if (!language) return fail(FaultKind::bad_input, "--language: {}", language.error().message);
      SystemClock clock;
      const auto heard = StatusWatch(arguments->status, clock).look();
      fmt::print("{}", state_text(heard, *language));
      return is_well(diagnose(heard).sight) ? 0 : kFailed;
    };
  });
}

std::atomic<bool> stopped = false, asked_to_try = false;

void add_run_command(CLI::App& app, Action& action) {
  struct Arguments {
    std::string config = kConfigFile;
    bool check = false;
  };
  auto* command = app.add_subcommand("run", "Reports the kiosk's state, as report.toml says, until SIGTERM");
  auto arguments = std::make_shared<Arguments>();
  command->add_option("--config", arguments->config, "What is reported, and to which recipients")
      ->capture_default_str();
  command->add_flag("--check", arguments->check, "Only reads the configuration, and names everything that is wrong");
  command->callback([arguments, &action] {
    action = [arguments]() -> Result<int> {
      const auto refused = [](const Fault& fault) {
        fmt::print(stderr, "kasumi-report: error: {}\n", fault.message);
        return fault.kind == FaultKind::bad_input ? kBadConfiguration : kFailed;
      };
      auto config = read_report_config(arguments->config);
      if (!config) return refused(config.error());
      if (arguments->check) {
        fmt::print("{}: configuration is valid\n", arguments->config);
        return 0;
      }
      // First, since the channels may say that it is here before start() returns.
      for (const int signal : {SIGTERM, SIGINT}) std::signal(signal, [](int) { stopped = true; });
      std::signal(SIGUSR1, [](int) { asked_to_try = true; });
      std::signal(SIGPIPE, SIG_IGN);
      SystemClock clock;
      const auto reporter = Reporter::start(std::move(*config), clock);
      if (!reporter) return refused(reporter.error());
      ::sd_notify(0, "READY=1");
      for (std::string told; !stopped;) {
        (*reporter)->turn();
        if (asked_to_try.exchange(false)) (*reporter)->begin_trial();
        ::sd_notify(0, "WATCHDOG=1");
        if (auto line = (*reporter)->line(); line != told) ::sd_notify(0, ("STATUS=" + (told = line)).c_str());
      }
      return 0;
    };
  });
}

void add_try_command(CLI::App& app, Action& action) {
  auto* command =
      app.add_subcommand("try", "Sends a trial through each channel of report.toml, and says what came of it");
  auto config_file = std::make_shared<std::string>(kConfigFile);
  command->add_option("--config", *config_file, "What is reported, and to which recipients")->capture_default_str();
  command->callback([config_file, &action] {
    action = [config_file]() -> Result<int> {
      const auto config = read_report_config(*config_file);
      if (!config) return fail(config.error());
      SystemClock clock;
      const auto heard = StatusWatch(config->status, clock).look();
      std::signal(SIGPIPE, SIG_IGN);
      bool all = true;
      const auto trials = try_channels(*config, heard, clock);
      for (const auto& trial : trials) {
        all = all && trial.came;
        fmt::print("{}: {}\n", trial.channel, trial.came ? *trial.came : "failed: " + trial.came.error().message);
      }
      if (trials.empty())
        fmt::print("{}: no channel to try: [mail], [mqtt], [sign_of_life], [content]\n", *config_file);
      return all ? 0 : kFailed;
    };
  });
}

void add_metrics_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("metrics", "Prints the kiosk's state as Prometheus reads it");
  auto status = std::make_shared<std::string>(kStatusFile);
  command->add_option("--status", *status, "The appliance's status file")->capture_default_str();
  command->callback([status, &action] {
    action = [status]() -> Result<int> {
      SystemClock clock;
      fmt::print("{}", metrics_text(StatusWatch(*status, clock).look(), disk_figures("/var/lib/kasumi"), {}));
      return 0;
    };
  });
}

void add_token_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("token", "Makes a token: one line to give away, and its hash for report.toml");
  command->callback([&action] {
    action = []() -> Result<int> {
      const auto made = new_token();
      if (!made) return fail(made.error());
      fmt::print("token = {}\n\n[[http.tokens]]\nname = \"\"\nhash = \"{}\"\n", made->token, made->hash);
      return 0;
    };
  });
}

int exit_code(const Fault& fault) {
  fmt::print(stderr, "kasumi-report: error: {}\n", fault.message);
  return fault.kind == FaultKind::bad_input ? kBadInput : kFailed;
}

}  // namespace

int main(int argc, char** argv) try {
  Action action;
  CLI::App app("Reports the kiosk's state: pages, metrics and messages for its operators", "kasumi-report");
  app.set_version_flag("--version", KASUMI_VERSION);
  app.require_subcommand(1);
  add_run_command(app, action);
  add_show_command(app, action);
  add_try_command(app, action);
  add_metrics_command(app, action);
  add_token_command(app, action);
  refuse_infinite_numbers(app);
  if (print_manual(app, KASUMI_VERSION, argc, argv)) return 0;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kBadInput;
  }
  const auto done = action();
  return done ? *done : exit_code(done.error());
} catch (const std::exception& error) {
  fmt::print(stderr, "kasumi-report: error: unexpected: {}\n", error.what());
  return kFailed;
}
