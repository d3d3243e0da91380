// The commands of `kasumi`. Each registers its options and sets `action` when it is selected.
#pragma once

#include <functional>

#include "base/result.hpp"

namespace CLI {
class App;
}

namespace kasumi {

// Returns the exit code: 0, or 2 when some of many inputs could not be read (each was reported).
using Action = std::function<Result<int>()>;

void add_replay_command(CLI::App& app, Action& action);
void add_estimate_command(CLI::App& app, Action& action);
void add_retarget_command(CLI::App& app, Action& action);
void add_sky_command(CLI::App& app, Action& action);
void add_haze_command(CLI::App& app, Action& action);
void add_look_command(CLI::App& app, Action& action);
void add_calibrate_command(CLI::App& app, Action& action);
void add_prove_command(CLI::App& app, Action& action);
void add_compare_command(CLI::App& app, Action& action);
void add_bench_command(CLI::App& app, Action& action);
void add_run_command(CLI::App& app, Action& action);
void add_reload_command(CLI::App& app, Action& action);
void add_content_command(CLI::App& app, Action& action);
void add_record_command(CLI::App& app, Action& action);
void add_snapshot_command(CLI::App& app, Action& action);
void add_doctor_command(CLI::App& app, Action& action);
void add_rehearse_command(CLI::App& app, Action& action);
void add_history_command(CLI::App& app, Action& action);

}  // namespace kasumi
