// An archive's figures drawn, each as SVG inside a page, without script; days and hours are wall time.
#pragma once

#include <string>

#include "pipeline/lab/archive/archive_figures.hpp"

namespace kasumi {

enum class ArchiveFigure { aod, cloud };

// By day: of the aerosol depth the median and what 68 % of the day's pictures lie between, of cloud the mean.
std::string plot_by_day(const ArchiveFigures& figures, ArchiveFigure figure);
// A square for each day, a block for each year.
std::string plot_calendar(const ArchiveFigures& figures, ArchiveFigure figure);
// Hours across, months down.
std::string plot_by_hour_and_month(const ArchiveFigures& figures, ArchiveFigure figure);
// How many pictures told the air with the sun at which azimuth (across) and height.
std::string plot_suns(const ArchiveFigures& figures);
// A bar for each reason, as share of all pictures; the rarest together.
std::string plot_refusals(const ArchiveFigures& figures);

}  // namespace kasumi
