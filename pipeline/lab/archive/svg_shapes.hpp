// What the plots of an archive are put together from.
#pragma once

#include <string>
#include <string_view>

#include "pipeline/site/files/html.hpp"

namespace kasumi {

constexpr std::string_view kPlotDark = "#222", kPlotQuiet = "#555", kPlotPale = "#ddd";

// Steps of an axis: round, five at most over `range`, which is more than 0.
double round_step(double range);

void open_svg(PageText& svg, double width, double height, std::string_view title);
void add_text(PageText& svg, double x, double y, std::string_view anchor, std::string_view words,
              std::string_view ink = kPlotQuiet);
void add_rule(PageText& svg, double x0, double y0, double x1, double y1, std::string_view ink = kPlotPale);
// `says`: shown where it is pointed at.
void add_square(PageText& svg, double x, double y, double width, double height, std::string_view colour,
                const std::string& says);

}  // namespace kasumi
