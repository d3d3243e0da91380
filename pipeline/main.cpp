// kasumi <command>: docs/architecture.md shows a frame's way through the program.
#include <cstdio>
#include <exception>

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "pipeline/command.hpp"

namespace {

constexpr int kFailed = 1;    // a fault of this machine
constexpr int kBadInput = 2;  // a fault in the input, which a person has to fix

int exit_code(const kasumi::Fault& fault) {
  return fault.kind == kasumi::FaultKind::bad_input ? kBadInput : kFailed;
}

}  // namespace

int main(int argc, char** argv) try {
  spdlog::set_default_logger(spdlog::stderr_color_mt("kasumi"));
  spdlog::set_pattern("kasumi: %^%l%$: %v");

  CLI::App app{"Kasumi: a vanished building, seen again under today's air", "kasumi"};
  app.set_version_flag("--version", KASUMI_VERSION);
  app.require_subcommand(1);
  kasumi::Action action;
  kasumi::add_run_command(app, action);
  kasumi::add_record_command(app, action);
  kasumi::add_doctor_command(app, action);
  kasumi::add_replay_command(app, action);
  kasumi::add_estimate_command(app, action);
  kasumi::add_retarget_command(app, action);
  kasumi::add_sky_command(app, action);
  kasumi::add_haze_command(app, action);
  kasumi::add_calibrate_command(app, action);
  kasumi::add_bench_command(app, action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kBadInput;
  }

  const auto done = action();
  if (done) return *done;
  fmt::print(stderr, "kasumi: {}\n", done.error().message);
  return exit_code(done.error());
} catch (const std::exception& error) {
  std::fprintf(stderr, "kasumi: unexpected: %s\n", error.what());
  return kFailed;
}
