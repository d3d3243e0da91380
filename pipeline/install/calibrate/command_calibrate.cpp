#include "pipeline/install/calibrate/command_calibrate.hpp"

#include <CLI/CLI.hpp>

namespace kasumi {

void add_calibrate_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("calibrate", "Calibrate the cameras, step by step, into one file");
  command->require_subcommand(1);
  add_calibrate_board(*command, action);
  add_calibrate_lens(*command, action);
  add_calibrate_sky(*command, action);
  add_calibrate_scene(*command, action);
  add_calibrate_response(*command, action);
  add_calibrate_focus(*command, action);
  add_calibrate_check(*command, action);
  add_calibrate_colour(*command, action);
  add_calibrate_mask(*command, action);
  add_calibrate_vignetting(*command, action);
  add_calibrate_report(*command, action);
}

}  // namespace kasumi
