#include <cstdio>
#include <cstdlib>

#include <CLI/CLI.hpp>

#include "base/outside/abandonable.hpp"
#include "pipeline/command.hpp"
#include "pipeline/kiosk/doctor/doctor.hpp"

namespace kasumi {

namespace {

struct DoctorArguments {
  std::string config = "/etc/kasumi/kasumi.toml";
  std::string content = kServiceContent;
  std::string status = MachinePlaces{}.status_file;
  bool json = false;
};

Result<int> run(const DoctorArguments& arguments) {
  SystemClock clock;
  const auto devices = machine_devices(clock);
  DoctorRequest request;
  request.config = arguments.config;
  request.generations = Generations(arguments.content);
  request.places.status_file = arguments.status;
  const auto findings = examine(request, *devices, clock);
  fmt::print("{}", arguments.json ? doctor_json(findings, clock.utc()) : doctor_text(findings));
  const int code = static_cast<int>(findings.worst());
  if (abandoned_threads == 0) return code;
  std::fflush(stdout);
  std::_Exit(code);  // a driver hangs
}

}  // namespace

void add_doctor_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand(
      "doctor",
      "Check everything the kiosk depends on and say what to do (exit code 0: no problem, 1: warnings, 2: failures)");
  auto arguments = std::make_shared<DoctorArguments>();
  command->add_option("--config", arguments->config, "kasumi.toml")->capture_default_str();
  command->add_option("--content", arguments->content, "The generations of `kasumi content`")->capture_default_str();
  command->add_option("--status", arguments->status, "The running appliance's status file")->capture_default_str();
  command->add_flag("--json", arguments->json, "Print JSON");
  command->callback([arguments, &action] { action = [arguments] { return run(*arguments); }; });
}

}  // namespace kasumi
