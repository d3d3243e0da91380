#include <cstdio>

#include <CLI/CLI.hpp>

#include "pipeline/bench/bench.hpp"
#include "pipeline/bench/gles.hpp"
#include "pipeline/bench/haze.hpp"
#include "pipeline/command.hpp"

namespace kasumi {

namespace {

void print(const std::vector<BenchRow>& rows) {
  for (const auto& row : rows) {
    const auto goal = row.goal ? fmt::format("{} {:g}", row.at_most ? "<=" : ">=", *row.goal) : std::string();
    fmt::print("{:<72} {:>10.4g} {:<10} {:<10} {}\n", row.name, row.value, row.unit, goal,
               !row.goal       ? ""
               : row.reached() ? "reached"
                               : "MISSED");
  }
}

}  // namespace

void add_bench_command(CLI::App& app, Action& action) {
  auto* command = app.add_subcommand("bench", "Cost of each part, as ratios of alternate measurements");
  command->callback([&action] {
    action = []() -> Result<int> {
      fmt::print("{:<72} {:>10} {:<10} {:<10}\n", "", "measured", "", "goal");
      print(bench_turbidity());
      print(bench_air());
      const auto gles = bench_gles();
      if (!gles) return fail(gles.error());
      print(*gles);
      const auto layer = bench_layer();
      if (!layer) return fail(layer.error());
      print(*layer);
      const auto dome = bench_dome();
      if (!dome) return fail(dome.error());
      print(*dome);
      const auto haze = bench_haze();
      if (!haze) return fail(haze.error());
      print(*haze);
      return 0;
    };
  });
}

}  // namespace kasumi
