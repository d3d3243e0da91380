// A figure says how exact something is, over many cases: all of them by `./bootstrap figures`; otherwise about a quarter,
// the worst that are known among them. What is asked of a case is the same either way.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace kasumi {

// KASUMI_FIGURES=whole
inline bool whole_figures() {
  const char* size = std::getenv("KASUMI_FIGURES");
  return size && std::string_view(size) == "whole";
}

// The cases to measure; how many of how many is told, so that nobody takes a quarter for the whole.
template <class Case>
std::vector<Case> figure_cases(const char* what, std::vector<Case> quarter, std::vector<Case> whole) {
  std::printf("figure of %zu of %zu %s\n", (whole_figures() ? whole : quarter).size(), whole.size(), what);
  return whole_figures() ? whole : quarter;
}

// A row of a table of docs/ that says `<!-- figures: TABLE by ... -->`: `./bootstrap figures` writes it there
// (docs/rewrite-figures). Nothing of a quarter of the cases goes into a document.
inline void figure_row(std::string_view table, const std::vector<std::string>& cells) {
  if (!whole_figures()) return;
  std::string row;
  for (const auto& cell : cells) row += fmt::format(" {} |", cell);
  fmt::print("figures of {} |{}\n", table, row);
  std::fflush(stdout);
}

// A number as the documents write it: .073 for 0.0731 with three decimals, -.3.
inline std::string figure_text(double value, int decimals) {
  auto text = fmt::format("{:.{}f}", value, decimals);
  const auto zero = text.find("0.");
  if (zero == 0 || (zero == 1 && text[0] == '-')) text.erase(zero, 1);
  return text;
}

// "1.4 to 2.6", or "1.4" where all are the same to that many decimals.
inline std::string figure_range(double least, double most, int decimals) {
  const auto from = figure_text(least, decimals), to = figure_text(most, decimals);
  return from == to ? from : from + " to " + to;
}

}  // namespace kasumi
