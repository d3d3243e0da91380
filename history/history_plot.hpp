// A history drawn: what visitors saw as a strip, T and the aerosol's optical depth with their sigma below.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "history/history_spells.hpp"

namespace kasumi {

struct PlotWords {
  std::string_view title = "What visitors saw, turbidity T and aerosol optical depth";
  std::string_view seen = "visitors saw", turbidity = "T", aod = "AOD at 550 nm", none = "no figures";
};

// From `from` to `to` in UTC; the axis says wall time, `wall` ahead of UTC. A whole SVG, without style sheet or script, that
// reads on paper, on a telephone and without colours: states differ in height, too.
std::string history_plot(const std::vector<HistoryLine>& lines, UtcMinute from, UtcMinute to, std::chrono::minutes wall,
                         const PlotWords& words = {});

}  // namespace kasumi
