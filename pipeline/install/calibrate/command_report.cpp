#include <CLI/CLI.hpp>

#include "base/clock.hpp"
#include "base/files.hpp"
#include "base/utc_text.hpp"
#include "pipeline/install/calibrate/command_calibrate.hpp"
#include "pipeline/install/calibration_report/report.hpp"

namespace kasumi {

namespace {

struct ReportArguments {
  std::string calibration;
  std::string out;
};

Result<int> report(const ReportArguments& arguments) {
  const auto read = read_calibration_report(arguments.calibration);
  if (!read) return fail(read.error());
  const auto now = utc_text(std::chrono::floor<std::chrono::seconds>(SystemClock().utc()));
  if (auto done = write_text_file(arguments.out, html_of(*read, now)); !done) return fail(done.error());
  for (const auto& camera : read->cameras)
    for (const auto& step : camera.missing)
      fmt::print("{}: still to be done: {} ({})\n", camera.name, step.what, step.missing);
  fmt::print("written: {}\n", arguments.out);
  return 0;
}

}  // namespace

void add_calibrate_report(CLI::App& calibrate_command, Action& action) {
  auto* command = calibrate_command.add_subcommand(
      "report", "One page of all that was measured, with its plots and what the numbers should be; opens offline");
  auto arguments = std::make_shared<ReportArguments>();
  command->add_option("calibration", arguments->calibration, "The calibration file")->required();
  command->add_option("--out", arguments->out, "The page (HTML)")->required();
  command->callback([arguments, &action] { action = [arguments] { return report(*arguments); }; });
}

}  // namespace kasumi
