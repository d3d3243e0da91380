#include <algorithm>
#include <cstdio>
#include <memory>

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include "base/files.hpp"
#include "gles/display/display_listing.hpp"
#include "gles/gl/context.hpp"
#include "pipeline/command.hpp"
#include "pipeline/lab/bench/bench.hpp"
#include "pipeline/lab/bench/gles.hpp"
#include "pipeline/lab/bench/haze.hpp"
#include "pipeline/lab/bench/machine_board.hpp"
#include "pipeline/lab/bench/recorded_run.hpp"

namespace kasumi {

namespace {

struct BenchArguments {
  bool markdown = false, board = false;
  std::vector<std::string> only;
  std::string json, against;
};

struct Part {
  const char* name;
  Result<std::vector<BenchRow>> (*measure)();
};

constexpr Part kParts[] = {
    {"turbidity", +[]() -> Result<std::vector<BenchRow>> { return bench_turbidity(); }},
    {"sky", +[]() -> Result<std::vector<BenchRow>> { return bench_sky_answer(); }},
    {"archive", +[] { return bench_archive(); }},
    {"air", +[]() -> Result<std::vector<BenchRow>> { return bench_air(); }},
    {"composite", +[] { return bench_gles(); }},
    {"layer", +[] { return bench_layer(); }},
    {"surroundings", +[] { return bench_surroundings(); }},
    {"people", +[] { return bench_people(); }},
    {"visitor", +[] { return bench_visitor(); }},
    {"dome", +[] { return bench_dome(); }},
    {"haze", +[] { return bench_haze(); }},
};

std::vector<std::string> part_names() {
  std::vector<std::string> names;
  for (const Part& part : kParts) names.emplace_back(part.name);
  return names;
}

std::string goal_of(const BenchRow& row) {
  return row.goal ? fmt::format("{} {:g}", row.less_is_better ? "<=" : ">=", *row.goal) : std::string();
}

// The table grows while it is measured.
class Table {
 public:
  Table(bool markdown, bool shown) : markdown_(markdown), shown_(shown) {
    if (!shown) return;
    if (markdown)
      fmt::print("| | measured | goal |\n|---|---|---|\n");
    else
      fmt::print("{:<72} {:>10} {:<10} {:<10}\n", "", "measured", "", "goal");
  }
  void add(const std::vector<BenchRow>& rows) const {
    if (!shown_) return;
    for (const auto& row : rows) {
      const auto reached = !row.goal ? "" : row.reached() ? "reached" : "MISSED";
      if (markdown_)
        fmt::print("| {} | {:.3g}{} | {}{} |\n", row.name.starts_with("  ") ? "... " + row.name.substr(2) : row.name,
                   row.value, row.unit == "x" ? "" : " " + row.unit, goal_of(row), row.reached() ? "" : ": **missed**");
      else
        fmt::print("{:<72} {:>10.4g} {:<10} {:<10} {}\n", row.name, row.value, row.unit, goal_of(row), reached);
    }
    std::fflush(stdout);
  }

 private:
  bool markdown_, shown_;
};

// Whether the kiosk's pictures need the GPU at all on this machine's displays.
void print_planes() {
  const auto cards = list_displays();
  if (cards.empty()) fmt::print("planes: no graphics card with a display: the GPU composes each picture\n");
  for (const auto& card : cards) {
    if (!card.plane_formats.empty())
      fmt::print("planes: {} ({}) lays the building over pictures in {} by itself\n", card.path, card.driver,
                 fmt::join(card.plane_formats, ", "));
    else
      fmt::print("planes: {} ({}): the GPU composes each picture: {}\n", card.path, card.driver,
                 !card.problem.empty()     ? card.problem
                 : !card.no_planes.empty() ? card.no_planes
                                           : "no display is connected");
  }
}

std::string renderer_name() {
  const auto context = open_headless_context();
  return context ? (*context)->info().renderer : std::string();
}

// What got slower, measured a second time by the parts that it belongs to; exit code 1 when something stays slower than
// it was on this machine.
Result<int> compare(RecordedRun& run, const RecordedRun& before, const std::string& file,
                    const std::vector<std::pair<const Part*, std::size_t>>& first_rows) {
  RunComparison compared = compare_runs(before, run);
  for (std::size_t i = 0; i < first_rows.size(); ++i) {
    const auto first = run.rows.begin() + static_cast<std::ptrdiff_t>(first_rows[i].second);
    const auto last = i + 1 < first_rows.size()
                          ? run.rows.begin() + static_cast<std::ptrdiff_t>(first_rows[i + 1].second)
                          : run.rows.end();
    const bool suspected = std::any_of(first, last, [&](const BenchRow& row) {
      return std::ranges::any_of(compared.slower, [&](const SlowerRow& slow) { return row.name.ends_with(slow.name); });
    });
    if (!suspected) continue;
    const auto again = first_rows[i].first->measure();
    if (!again) return fail(again.error());
    keep_better(run.rows, *again);
  }
  compared = compare_runs(before, run);
  std::string said;
  if (!compared.same_machine)
    said += fmt::format(
        "{} was recorded on another machine ({}; {}): times were not compared, and a ratio that changed is no "
        "failure\n",
        file, before.processor, before.renderer.empty() ? "no GL" : before.renderer);
  for (const auto& name : compared.not_found) said += fmt::format("not in {}: {}\n", file, name);
  for (const auto& row : compared.slower)
    said += fmt::format("slower by {:.0f} % (measured twice): {}: {:.3g} {}, was {:.3g}\n", 100 * (row.growth() - 1),
                        row.name, row.now, row.unit, row.before);
  if (compared.slower.empty()) said += fmt::format("nothing is more than 10 % slower than in {}\n", file);
  fmt::print(stderr, "{}", said);
  return compared.is_regression() ? 1 : 0;
}

Result<int> bench(const BenchArguments& arguments, const std::string& version) {
  std::optional<RecordedRun> before;
  if (!arguments.against.empty()) {
    auto read = read_recorded_run(arguments.against);
    if (!read) return fail(read.error());
    before = std::move(*read);
  }
  RecordedRun run{.version = version,
                  .processor = processor_of(read_text_file("/proc/cpuinfo").value_or("")),
                  .renderer = renderer_name(),
                  .rows = {}};
  const Table table(arguments.markdown, arguments.json != "-");
  std::vector<std::pair<const Part*, std::size_t>> first_rows;
  for (const Part& part : kParts) {
    if (!arguments.only.empty() && std::ranges::find(arguments.only, part.name) == arguments.only.end()) continue;
    const auto rows = part.measure();
    if (!rows) return fail(rows.error());
    table.add(*rows);
    first_rows.emplace_back(&part, run.rows.size());
    run.rows.insert(run.rows.end(), rows->begin(), rows->end());
  }
  if (arguments.only.empty() && !arguments.markdown && arguments.json != "-") print_planes();
  const auto code = before ? compare(run, *before, arguments.against, first_rows) : Result<int>(0);
  if (!code) return code;
  if (arguments.json == "-")
    fmt::print("{}", json_of(run));
  else if (!arguments.json.empty())
    if (auto written = write_text_file(arguments.json, json_of(run)); !written) return fail(written.error());
  return code;
}

}  // namespace

void add_bench_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("bench", "Cost of each part, as ratios of alternate measurements");
  auto arguments = std::make_shared<BenchArguments>();
  command->add_flag("--markdown", arguments->markdown, "As a table of Markdown, as docs/performance.md has it");
  command->add_option("--only", arguments->only, "These parts alone")->check(CLI::IsMember(part_names()));
  command->add_option("--json", arguments->json, "Writes the run to this file (-: to standard output, and no table)");
  command->add_option("--against", arguments->against,
                      "Names what became more than 10 % slower since the run in this file, which --json wrote, after "
                      "measuring it twice; exit code 1 if anything did and the run is of this machine");
  command
      ->add_flag("--board", arguments->board,
                 "What this machine is, which path pictures take on it and what that costs, to be sent: within 2 "
                 "minutes, without a camera and without personal data")
      ->excludes("--markdown", "--only", "--json", "--against");
  command->callback([&action, &app, arguments] {
    action = [arguments, version = app.version()]() -> Result<int> {
      if (!arguments->board) return bench(*arguments, version);
      print_board(version);
      return 0;
    };
  });
}

}  // namespace kasumi
