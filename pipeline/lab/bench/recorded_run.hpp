// A run of `kasumi bench` as a file, and what a later run shows against it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "pipeline/lab/bench/bench.hpp"

namespace kasumi {

struct RecordedRun {
  std::string version;    // of Kasumi
  std::string processor;  // processor_of(...)
  std::string renderer;   // GL's: "llvmpipe (LLVM 15.0.6, 256 bits)"; empty: nothing was drawn
  std::vector<BenchRow> rows;
};

// What identifies a machine in /proc/cpuinfo: "2 x AMD EPYC, cpu family 25, model 1, stepping 1"; a virtual machine's
// model name alone may be that of several generations.
std::string processor_of(const std::string& cpuinfo);

// "kasumi", "processor", "renderer" and "rows", each with name, value, unit, goal (or null), less_is_better.
std::string json_of(const RecordedRun& run);
// Errors: io; bad_input with all problems, naming file and row.
Result<RecordedRun> read_recorded_run(const std::filesystem::path& file);

// The growth of a cost that is reported.
constexpr double kToldGrowth = 1.10;

struct SlowerRow {
  std::string name;
  std::string unit;
  double before = 0.0;
  double now = 0.0;
  bool less_is_better = true;
  double growth() const;  // of the cost: 1.14 is 14 % slower
};

struct RunComparison {
  std::vector<SlowerRow> slower;       // in the order of the run
  std::vector<std::string> not_found;  // measured now, not recorded then
  std::vector<std::string> gone;       // recorded then, not measured now
  bool same_machine = true;            // else times were not compared: they belong to a machine
  // Ratios, too, depend on the machine: against another one they are reported, but never a regression.
  bool is_regression() const { return same_machine && !slower.empty(); }
};

// Rows are compared by their names, leading blanks left out.
RunComparison compare_runs(const RecordedRun& before, const RecordedRun& now);

// Of each row the better of two measurements: a busy machine only ever makes a part look slower.
void keep_better(std::vector<BenchRow>& rows, const std::vector<BenchRow>& again);

}  // namespace kasumi
