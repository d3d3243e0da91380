#include "pipeline/lab/archive/summary_page.hpp"

#include <algorithm>
#include <array>
#include <cstdlib>

#include "base/utc_text.hpp"
#include "pipeline/lab/archive/archive_plots.hpp"
#include "pipeline/site/files/html.hpp"

namespace kasumi {
namespace {

constexpr std::string_view kSummaryStyle = R"(
:root { color-scheme: light; }
body { font: 16px/1.45 system-ui, "DejaVu Sans", sans-serif; color: #222; background: #fff; margin: 0 auto; max-width: 66rem; padding: 1rem; }
h1 { font-size: 1.6rem; margin: 0 0 .3rem; } h2 { font-size: 1.25rem; margin: 2rem 0 .3rem; border-bottom: 2px solid #888; }
h3 { font-size: 1rem; margin: 1.2rem 0 .3rem; } p { margin: .4rem 0; } .quiet { color: #555; font-size: .9rem; overflow-wrap: anywhere; }
table { border-collapse: collapse; margin: .6rem 0; }
th, td { text-align: right; padding: .25rem .8rem .25rem 0; border-bottom: 1px solid #ddd; font-variant-numeric: tabular-nums; }
th { font-size: .85rem; color: #555; font-weight: normal; } th:first-child { text-align: left; }
svg { display: block; width: 100%; height: auto; }
@media print { body { font-size: 10.5pt; max-width: none; padding: 0; } svg, table { break-inside: avoid; } }
)";

struct Season {
  const char* name;
  std::array<std::size_t, 3> months;
};
constexpr std::array kSeasons{Season{"December to February", {11, 0, 1}}, Season{"March to May", {2, 3, 4}},
                              Season{"June to August", {5, 6, 7}}, Season{"September to November", {8, 9, 10}}};

std::string zone_name(std::chrono::minutes ahead) {
  const auto size = std::abs(ahead.count());
  if (size == 0) return "UTC";
  return fmt::format("UTC{}{:02}:{:02}", ahead.count() < 0 ? "-" : "+", size / 60, size % 60);
}

void add_season(PageText& page, const char* name, const Cell& cell) {
  page.add("<tr><th scope=\"row\">{}</th><td>{}</td><td>{}</td>", name, cell.pictures(), cell.aods());
  if (const auto aod = cell.aod())
    page.add("<td>{:.3f}</td><td>{:.3f} to {:.3f}</td>", aod->median, aod->low, aod->high);
  else
    page.add("<td>-</td><td>-</td>");
  if (const auto cloud = cell.cloud())
    page.add("<td>{:.0f} %</td></tr>\n", 100.0 * *cloud);
  else
    page.add("<td>-</td></tr>\n");
}

void add_seasons(PageText& page, const ArchiveFigures& figures) {
  page.add(
      "<h2>By season</h2>\n<table><thead><tr><th scope=\"col\">season</th><th scope=\"col\">pictures</th>"
      "<th scope=\"col\">air known</th><th scope=\"col\">AOD, median</th><th scope=\"col\">68 % between</th>"
      "<th scope=\"col\">cloud, mean</th></tr></thead><tbody>\n");
  Cell all;
  for (const auto& season : kSeasons) {
    Cell cell;
    for (const std::size_t month : season.months) cell.add(figures.month(month));
    add_season(page, season.name, cell);
    all.add(cell);
  }
  add_season(page, "all", all);
  page.add("</tbody></table>\n");
}

void add_over_time(PageText& page, const ArchiveFigures& figures) {
  page.add(
      "<h2>Aerosol optical depth at 550 nm</h2>\n<p class=\"quiet\">By day: the median of its pictures, and what 68 % "
      "of "
      "them lie between. Days without a clear part of the sky have none; so a mean over days is one over clear "
      "days.</p>\n{}<h3>By date</h3>\n{}<h3>By hour and month</h3>\n{}",
      plot_by_day(figures, ArchiveFigure::aod), plot_calendar(figures, ArchiveFigure::aod),
      plot_by_hour_and_month(figures, ArchiveFigure::aod));
  page.add(
      "<h2>Cloud cover</h2>\n<p class=\"quiet\">By day: the mean share of the sky that is cloud, over the pictures "
      "that "
      "show it; nights are left out.</p>\n{}<h3>By date</h3>\n{}<h3>By hour and month</h3>\n{}",
      plot_by_day(figures, ArchiveFigure::cloud), plot_calendar(figures, ArchiveFigure::cloud),
      plot_by_hour_and_month(figures, ArchiveFigure::cloud));
}

}  // namespace

std::string summary_page(const ArchiveSummary& summary) {
  const auto& figures = summary.figures;
  const auto& archive = summary.archive;
  PageText page;
  page.add(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>Archive of sky "
      "pictures</title>\n"
      "<style>{}</style>\n</head>\n<body>\n<main>\n<h1>Archive of sky pictures</h1>\n",
      kSummaryStyle);
  const auto counted = std::max<std::size_t>(1, figures.pictures() - figures.exposures());
  const double share = 100.0 * static_cast<double>(figures.usable()) / static_cast<double>(counted);
  page.add("<p>{} pictures, each exactly once", figures.pictures());
  if (figures.first()) page.add(", from {} to {}", utc_text(*figures.first()), utc_text(*figures.last()));
  page.add(". The air is known from {} of them ({:.1f} %).", figures.usable(), share);
  if (figures.exposures() > 0)
    page.add(" {} are exposures of stacks, each counted once, by its first picture.", figures.exposures());
  if (figures.timeless() > 0) page.add(" {} have no time: they are in no plot over time.", figures.timeless());
  if (figures.nights() > 0)
    page.add(" {} are left out by rule: the sun was below the horizon, and their light the moon's or a lamp's.",
             figures.nights());
  page.add("</p>\n<p class=\"quiet\">Days and hours are {}. List {}, options {}.</p>\n", zone_name(figures.ahead()),
           html_escaped(archive.list), html_escaped(archive.options));
  if (!figures.days().empty()) {
    add_over_time(page, figures);
    add_seasons(page, figures);
    page.add("{}", series_sections(summary));
  }
  if (figures.usable() > 0)
    page.add(
        "<h2>Sun positions used</h2>\n<p class=\"quiet\">Pictures whose air is known, by the sun's azimuth and its "
        "height over the horizon.</p>\n{}",
        plot_suns(figures));
  page.add("<h2>Refused</h2>\n<p class=\"quiet\">Share of all pictures whose air is not known, by reason.</p>\n{}",
           plot_refusals(figures));
  page.add("</main>\n</body>\n</html>\n");
  return std::move(page).text();
}

}  // namespace kasumi
