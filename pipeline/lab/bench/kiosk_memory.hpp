// What a running kiosk takes of the machine's memory (`kasumi bench --memory`).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "pipeline/lab/bench/bench.hpp"

namespace kasumi {

// Runs the kiosk on a fixture's recordings and building, on a screen of full HD that nobody sees, and reads what the
// kernel says of the process half a minute after its picture is live. BLOCKS for about a minute.
// Errors: bad_input (the fixture), device (no live picture), io.
Result<std::vector<BenchRow>> bench_memory(const std::filesystem::path& fixture);

// From the text of /proc/PID/smaps: kilobytes of all mappings, of those without a file, and of the GL driver's libraries.
struct ResidentMemory {
  double all_kb = 0.0;
  double own_kb = 0.0;       // written by the process
  double gl_files_kb = 0.0;  // pages of the driver's files that it shares with the disk
};
ResidentMemory resident_memory(const std::string& smaps);

}  // namespace kasumi
