// What the program says on stderr, and to the journal with its priority (`journalctl -p warning`).
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include <spdlog/formatter.h>
#include <spdlog/sinks/sink.h>

#include "base/clock.hpp"

namespace kasumi {

// stderr is systemd's journal, as $JOURNAL_STREAM says.
bool stderr_is_journal();
bool stdout_is_journal();

// Logging goes to stderr from now on: "kasumi: warning: ...", for the journal with "<4>" before each line (sd-daemon(3)).
void log_to_stderr();
std::unique_ptr<spdlog::formatter> journal_formatter();
// For a program that must go on: from now on stderr that takes no more (a journal that hangs) loses lines, which are
// counted, instead of holding up the thread that logs; and a reader that has ended does not end this program.
void never_wait_for_log();

// An error that ends the program, of one or more lines. The unit takes lines without a priority for warnings: libraries
// write such.
void print_error(std::string_view text);
// The same without "kasumi: " before it, as the command line's parser words it.
void print_refusal(std::string_view text);
// What went well, on stdout.
void print_success(std::string_view text);

// Passes on at most 20 lines at once about one thing (what stands before the first ": ") and then one in ten minutes,
// which says how many were left out. flush() writes the last line left out once its pause is over, so that the newest
// line is current.
std::shared_ptr<spdlog::sinks::sink> bounded_lines(std::shared_ptr<spdlog::sinks::sink> next, Clock& clock);
// Bounds what is logged from now on. `clock` must outlive all logging.
void bound_log(Clock& clock);

}  // namespace kasumi
