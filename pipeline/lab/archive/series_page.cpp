// The page's sections on years: trend, weather, photometer and the camera's drift.
#include <fmt/format.h>

#include "pipeline/lab/archive/series_plots.hpp"
#include "pipeline/lab/archive/summary_page.hpp"
#include "pipeline/site/files/html.hpp"

namespace kasumi {
namespace {

void add_trend(PageText& page, const ArchiveFigures& figures) {
  const auto months = monthly_aod(figures);
  page.add("<h2>Trend</h2>\n");
  const auto trend = trend_of(months);
  if (!trend) {
    page.add("<p>No trend is given: {}.</p>\n", html_escaped(trend.error().message));
    return;
  }
  page.add(
      "<p>Aerosol optical depth at 550 nm changes by {:+.4f} &#177; {:.4f} a year ({:+.1f} % of its mean), by {} "
      "months."
      "</p>\n<p class=\"quiet\">Means over a month of the days' medians, less a season of one and half a year. Sigma "
      "holds that a month resembles the one before (autocorrelation {:.2f}; Weatherhead 1998). What the camera "
      "itself did in these years is in the trend, too: see its drift below.</p>\n{}",
      trend->per_year, trend->sigma, 100.0 * trend->per_year / trend->level, trend->months, trend->autocorrelation,
      plot_trend(months, *trend));
}

void add_weather(PageText& page, const SeriesFigures& series) {
  page.add(
      "<h2>Gaps by weather</h2>\n<p class=\"quiet\">What became of each month's pictures. The air is known of clear "
      "skies: a month of clouds is known by its few clear hours.</p>\n{}",
      plot_fates(series));
}

void add_photometer(PageText& page, const PhotometerComparison& comparison) {
  page.add("<h2>Against the photometer</h2>\n");
  const auto all = comparison.agreement();
  if (all.pairs == 0) {
    page.add("<p>No picture whose air is known was taken within 15 minutes of one of its {} readings.</p>\n",
             comparison.readings());
    return;
  }
  page.add(
      "<p>{} pictures within 15 minutes of one of its {} readings: bias {:+.3f}, RMSE {:.3f}, 95 % of the differences "
      "within {:+.3f} and {:+.3f}; {:.0f} % within the expected error of &#177; (0.05 + 0.15 AOD).</p>\n<p "
      "class=\"quiet\">Camera less photometer, which is brought to 550 nm by a parabola of its channels from 400 to "
      "900 "
      "nm in logarithms. The camera's depth is from sea level upwards, the photometer's from where it stands.</p>\n{}",
      all.pairs, comparison.readings(), all.bias, all.rmse, all.bias - 1.96 * all.scatter,
      all.bias + 1.96 * all.scatter, 100.0 * all.within_expected, plot_agreement(comparison));
}

void add_drift(PageText& page, const SeriesFigures& series) {
  const auto suns = plot_drift(series, "degrees between the sun seen and where time, place and camera put it",
                               [](const MonthlyTally& month) { return month.sun_off_deg(); });
  const auto radii = plot_drift(series, "radius of the image circle in pixels",
                                [](const MonthlyTally& month) { return month.radius_px(); });
  if (suns.empty() && radii.empty()) return;
  page.add(
      "<h2>The camera's drift</h2>\n<p class=\"quiet\">Medians of each month. A step is a camera that was moved or "
      "refocused: give each time its own file by --camera.</p>\n");
  if (!suns.empty()) page.add("<h3>Where the sun is seen, degrees off</h3>\n{}", suns);
  if (!radii.empty()) page.add("<h3>Radius of the image circle, pixels</h3>\n{}", radii);
}

}  // namespace

std::string series_sections(const ArchiveSummary& summary) {
  PageText page;
  add_trend(page, summary.figures);
  add_weather(page, summary.series);
  if (summary.photometer) add_photometer(page, *summary.photometer);
  add_drift(page, summary.series);
  return std::move(page).text();
}

}  // namespace kasumi
