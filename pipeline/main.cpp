// kasumi <command>: docs/architecture.md shows a frame's way through the program.
#include <exception>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "pipeline/command_line.hpp"
#include "pipeline/log_lines.hpp"

namespace {

constexpr int kFailed = 1;    // a fault of this machine
constexpr int kBadInput = 2;  // a fault in the input, which a person has to fix

int exit_code(const kasumi::Fault& fault) {
  return fault.kind == kasumi::FaultKind::bad_input ? kBadInput : kFailed;
}

}  // namespace

int main(int argc, char** argv) try {
  kasumi::log_to_stderr();

  kasumi::Action action;
  const auto app = kasumi::command_line(action);
  app->set_version_flag("--version", KASUMI_VERSION);
  try {
    app->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app->exit(error) == 0 ? 0 : kBadInput;
  }

  const auto done = action();
  if (done) return *done;
  kasumi::print_error(done.error().message);
  return exit_code(done.error());
} catch (const std::exception& error) {
  kasumi::print_error(fmt::format("unexpected: {}", error.what()));
  return kFailed;
}
