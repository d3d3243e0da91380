#include "tests/paper/report/svg_plot.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include <fmt/format.h>

#include "pipeline/site/files/html.hpp"

namespace kasumi::paper {
namespace {

constexpr double kWidth = 640, kHeight = 380, kLeft = 64, kRight = 16, kTop = 34, kBottom = 48, kLegendLine = 17;
// Distinguishable without colour vision as well (Okabe and Ito 2008).
constexpr const char* kColours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#000000", "#e69f00", "#56b4e9"};

struct Axis {
  double lowest = 0.0, highest = 1.0;
  bool logarithmic = false;
  double place(double value) const {
    return logarithmic ? std::log(value / lowest) / std::log(highest / lowest) : (value - lowest) / (highest - lowest);
  }
  bool shows(double value) const { return !logarithmic || value > 0.0; }
  std::vector<double> ticks() const {
    std::vector<double> found;
    if (logarithmic) {
      const bool few = highest / lowest > 1e3;
      for (double decade = std::pow(10.0, std::floor(std::log10(lowest))); decade <= highest; decade *= 10.0)
        for (const double step : {1.0, 2.0, 5.0})
          if ((!few || step < 1.5) && step * decade >= lowest * 0.999 && step * decade <= highest * 1.001)
            found.push_back(step * decade);
      return found;
    }
    const double rough = (highest - lowest) / 6.0, decade = std::pow(10.0, std::floor(std::log10(rough)));
    const double step = decade * (rough / decade < 1.5   ? 1.0
                                  : rough / decade < 3.5 ? 2.0
                                  : rough / decade < 7.5 ? 5.0
                                                         : 10.0);
    for (double i = std::ceil(lowest / step - 1e-9); i * step <= highest + 1e-9 * step; ++i)
      found.push_back(i * step + 0.0);  // never -0
    return found;
  }
};

Axis axis_of(const Plot& plot, int component, bool logarithmic, const std::optional<glm::dvec2>& range) {
  if (range) return {range->x, range->y, logarithmic};
  Axis axis{std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest(), logarithmic};
  for (const auto& series : plot.series)
    for (const auto& point : series.points) {
      if (!axis.shows(point[component])) continue;
      axis.lowest = std::min(axis.lowest, point[component]);
      axis.highest = std::max(axis.highest, point[component]);
    }
  if (!(axis.lowest < axis.highest)) return {logarithmic ? 0.1 : 0.0, logarithmic ? 10.0 : 1.0, logarithmic};
  if (component == 1 && !logarithmic) {
    const double spare = 0.05 * (axis.highest - axis.lowest);
    axis.lowest -= axis.lowest > 0.0 && axis.lowest < spare ? axis.lowest : spare;
    axis.highest += spare;
  }
  return axis;
}

}  // namespace

std::string svg_of(const Plot& plot) {
  const Axis across = axis_of(plot, 0, plot.log_across, plot.range_across),
             up = axis_of(plot, 1, plot.log_up, plot.range_up);
  const double wide = kWidth - kLeft - kRight, high = kHeight - kTop - kBottom;
  const double total = kHeight + kLegendLine * static_cast<double>((plot.series.size() + 1) / 2);
  const auto x_of = [&](double value) { return kLeft + wide * across.place(value); };
  const auto y_of = [&](double value) { return kTop + high * (1.0 - up.place(value)); };
  std::string svg;
  const auto add = [&]<class... Args>(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(svg), format, std::forward<Args>(args)...);
  };
  add("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\" font-family=\"sans-serif\" "
      "font-size=\"12\"><title>{}</title>\n",
      kWidth, total, html_escaped(plot.title));
  // Plots of one page need frames with different names, derived from the title.
  const auto frame = fmt::format("frame{:x}", std::hash<std::string>{}(plot.title));
  add("<clipPath id=\"{}\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>\n", frame, kLeft, kTop, wide,
      high);
  add("<text x=\"{}\" y=\"20\" font-size=\"14\">{}</text>\n", kLeft, html_escaped(plot.title));
  for (std::size_t i = 0; i < plot.bands.size(); ++i) {
    const auto& band = plot.bands[i];
    const double top = std::max(kTop, y_of(band.to)),
                 bottom = std::min(kTop + high, y_of(std::max(band.from, up.logarithmic ? up.lowest : band.from)));
    if (bottom <= top) continue;
    add("<rect x=\"{}\" y=\"{:.1f}\" width=\"{}\" height=\"{:.1f}\" fill=\"{}\"/>\n", kLeft, top, wide, bottom - top,
        i % 2 == 0 ? "#f1f1f1" : "#ffffff");
    add("<text x=\"{}\" y=\"{:.1f}\" fill=\"#777\" text-anchor=\"end\">{}</text>\n", kLeft + wide - 4,
        0.5 * (top + bottom) + 4, html_escaped(band.name));
  }
  for (const double value : across.ticks())
    add("<path d=\"M{0:.1f} {1}V{2}\" stroke=\"#ddd\"/><text x=\"{0:.1f}\" y=\"{3}\" "
        "text-anchor=\"middle\">{4:g}</text>\n",
        x_of(value), kTop, kTop + high, kTop + high + 16, value);
  for (const double value : up.ticks())
    add("<path d=\"M{0} {1:.1f}H{2}\" stroke=\"#ddd\"/><text x=\"{3}\" y=\"{4:.1f}\" "
        "text-anchor=\"end\">{5:g}</text>\n",
        kLeft, y_of(value), kLeft + wide, kLeft - 6, y_of(value) + 4, value);
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const auto& series = plot.series[i];
    const char* colour = kColours[i % std::size(kColours)];
    std::string path;
    for (const auto& point : series.points) {
      if (!across.shows(point.x) || !up.shows(point.y)) continue;
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? 'M' : 'L', x_of(point.x), y_of(point.y));
      if (series.marks)
        add("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\" fill=\"{}\" clip-path=\"url(#{})\"/>\n", x_of(point.x),
            y_of(point.y), colour, frame);
    }
    if (series.line && !path.empty())
      add("<path d=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"2\"{} clip-path=\"url(#{})\"/>\n", path, colour,
          series.dashed ? " stroke-dasharray=\"6 4\"" : "", frame);
    const double x = kLeft + (i % 2 == 0 ? 0.0 : 0.5 * wide),
                 y = kHeight + kLegendLine * static_cast<double>(i / 2) + 4;
    add("<path d=\"M{} {}h22\" stroke=\"{}\" stroke-width=\"2\"{}/><text x=\"{}\" y=\"{}\">{}</text>\n", x, y - 4,
        colour, series.dashed ? " stroke-dasharray=\"6 4\"" : "", x + 28, y, html_escaped(series.name));
  }
  add("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#444\"/>\n", kLeft, kTop, wide, high);
  add("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", kLeft + 0.5 * wide, kTop + high + 34,
      html_escaped(plot.across));
  add("<text transform=\"translate(14 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n</svg>\n", kTop + 0.5 * high,
      html_escaped(plot.up));
  return svg;
}

}  // namespace kasumi::paper
