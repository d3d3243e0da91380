// kasumi <command>: docs/architecture.md shows a frame's way through the program.
#include <cstdlib>
#include <exception>
#include <iostream>
#include <sstream>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "base/manual/manual.hpp"
#include "pipeline/command_line.hpp"
#include "pipeline/log_lines.hpp"

namespace {

constexpr int kFailed = 1;    // a fault of this machine
constexpr int kBadInput = 2;  // a fault in the input, which a person has to fix

int exit_code(const kasumi::Fault& fault) {
  return fault.kind == kasumi::FaultKind::bad_input ? kBadInput : kFailed;
}

// For uncaught exceptions, as in a library's thread.
[[noreturn]] void say_why_and_abort() {
  try {
    if (const auto thrown = std::current_exception()) std::rethrow_exception(thrown);
    kasumi::print_error("unexpected: terminated");
  } catch (const std::exception& error) {
    kasumi::print_error(fmt::format("unexpected: {}", error.what()));
  } catch (...) {
    kasumi::print_error("unexpected: unknown exception");
  }
  std::abort();
}

int parse_error(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv) {
  std::ostringstream refusal;
  const int code = app.exit(error, std::cout, refusal);
  if (code != 0) refusal << kasumi::meant_instead(app, refusal.str(), argc, argv);
  kasumi::print_refusal(refusal.str());
  return code == 0 ? 0 : kBadInput;
}

}  // namespace

int main(int argc, char** argv) try {
  std::set_terminate(say_why_and_abort);
  kasumi::log_to_stderr();

  kasumi::Action action;
  const auto app = kasumi::command_line(action);
  app->set_version_flag("--version", KASUMI_VERSION);
  if (kasumi::print_manual(*app, KASUMI_VERSION, argc, argv)) return 0;
  try {
    app->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return parse_error(*app, error, argc, argv);
  }

  const auto done = action();
  if (done) return *done;
  kasumi::print_error(done.error().message);
  return exit_code(done.error());
} catch (const std::exception& error) {
  kasumi::print_error(fmt::format("unexpected: {}", error.what()));
  return kFailed;
}
