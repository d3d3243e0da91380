// The steps of `kasumi calibrate`.
#pragma once

#include "pipeline/command.hpp"

namespace kasumi {

void add_calibrate_board(CLI::App& calibrate_command, Action& action);
void add_calibrate_lens(CLI::App& calibrate_command, Action& action);
void add_calibrate_sky(CLI::App& calibrate_command, Action& action);
void add_calibrate_scene(CLI::App& calibrate_command, Action& action);
void add_calibrate_response(CLI::App& calibrate_command, Action& action);
void add_calibrate_focus(CLI::App& calibrate_command, Action& action);
void add_calibrate_check(CLI::App& calibrate_command, Action& action);
void add_calibrate_colour(CLI::App& calibrate_command, Action& action);
void add_calibrate_mask(CLI::App& calibrate_command, Action& action);
void add_calibrate_vignetting(CLI::App& calibrate_command, Action& action);
void add_calibrate_report(CLI::App& calibrate_command, Action& action);

}  // namespace kasumi
