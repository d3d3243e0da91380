#include <fmt/format.h>

#include "pipeline/lab/bench/gles.hpp"
#include "tests/paper/report/section.hpp"

namespace kasumi::paper {

Section frame_rate_section(const ReportOptions& options) {
  Section section("frame-rate", "Frame rate against the papers' layout: M Sect 6 and 7.3");
  section.say(
      "M: 14 frames a second in full HD on a GeForce GTX 550 Ti, 225 times as fast as Zhao. M's card cannot be had "
      "here, so what counts is the ratio of two ways on one machine in one run: M's two off-screen buffers and a "
      "compositing pass over the whole picture, against one background and the object's layer, drawn when air, sun "
      "or pose change. Above 1: Kasumi is faster.");
  if (options.quick) {
    section.finding(Finding::skipped, "a quick measurement of time is meaningless.");
    return section;
  }
  const auto rows = bench_gles();
  if (!rows) {
    section.finding(Finding::skipped, rows.error().message);
    return section;
  }
  std::vector<std::vector<std::string>> table;
  double against_papers = 0.0, against_81 = 0.0;
  for (const auto& row : *rows) {
    table.push_back({row.name, fmt::format("{:.3g} {}", row.value, row.unit)});
    if (row.name.starts_with("the papers' two buffers")) against_papers = row.value;
    if (row.name.starts_with("  the papers' two buffers with 81")) against_81 = row.value;
  }
  section.table({"full HD, headless", "measured"}, table);
  section.figure("papers_layout_over_ours", against_papers);
  section.figure("papers_layout_of_81_wavelengths_over_ours", against_81);
  section.finding(
      against_papers > 1.0 ? Finding::better : Finding::differs,
      fmt::format("the papers' layout takes {:.2f} times as long as ours, with their sum over 81 wavelengths in "
                  "each fragment {:.0f} times.",
                  against_papers, against_81));
  section.say(
      "M's 14 frames a second and its factor of 225 over Zhao belong to M's machine and to a program that is not "
      "public; neither can be measured here.");
  return section;
}

}  // namespace kasumi::paper
