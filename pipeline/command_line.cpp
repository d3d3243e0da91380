#include "pipeline/command_line.hpp"

#include <CLI/CLI.hpp>

#include "base/manual/finite_options.hpp"

namespace kasumi {

std::unique_ptr<CLI::App> command_line(Action& action) {
  auto app = std::make_unique<CLI::App>("Kasumi: a vanished building, seen again under today's air", "kasumi");
  app->require_subcommand(1);
  app->footer(
      "Exit codes: 0 done; 1 this machine could not do it; 2 something given must be corrected, and the message says "
      "what is expected (run: 78 in place of 2). docs/commands.md explains each command with an example.");
  add_run_command(*app, action);
  add_reload_command(*app, action);
  add_content_command(*app, action);
  add_record_command(*app, action);
  add_snapshot_command(*app, action);
  add_doctor_command(*app, action);
  add_look_command(*app, action);
  add_rehearse_command(*app, action);
  add_history_command(*app, action);
  add_replay_command(*app, action);
  add_estimate_command(*app, action);
  add_retarget_command(*app, action);
  add_sky_command(*app, action);
  add_haze_command(*app, action);
  add_compare_command(*app, action);
  add_prove_command(*app, action);
  add_calibrate_command(*app, action);
  add_bench_command(*app, action);
  refuse_infinite_numbers(*app);
  return app;
}

}  // namespace kasumi
