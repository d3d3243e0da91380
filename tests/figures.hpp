// A figure says how exact something is, over many cases. With every landing about a quarter of them is measured, the
// worst that are known among them; all of them by `./bootstrap figures`. What is asked of a case is the same either
// way.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <vector>

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

}  // namespace kasumi
