// Growth as a table and as plots: a panel for each curve, both axes logarithmic.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/files.hpp"
#include "pipeline/lab/bench/growth.hpp"

namespace kasumi {
namespace {

struct Line {
  const char* name;
  const char* colour;
  double GrowthCost::*cost;
};
constexpr Line kLines[] = {{"a picture, ms", "#1f5fa8", &GrowthCost::picture_ms},
                           {"the layer redrawn, ms", "#c2571a", &GrowthCost::redraw_ms},
                           {"peak of the process, MiB", "#4d7f3a", &GrowthCost::peak_mib}};

constexpr double kPanelWidth = 420, kPanelHeight = 260, kLeft = 52, kBelow = 40, kAbove = 30;

// A decade-wide axis at least, in tenths of decades.
struct LogAxis {
  double lowest = 0.0, highest = 1.0;
  double from = 0.0, to = 1.0;
  double at(double value) const { return from + (to - from) * (std::log10(value) - lowest) / (highest - lowest); }
};

LogAxis axis_over(double least, double most, double from, double to) {
  LogAxis axis{std::floor(10 * std::log10(least)) / 10, std::ceil(10 * std::log10(most)) / 10, from, to};
  if (axis.highest <= axis.lowest) axis.highest = axis.lowest + 1.0;
  return axis;
}

std::string mark_text(double value) {
  if (value >= 1e6) return fmt::format("{:g} M", value / 1e6);
  if (value >= 1e4) return fmt::format("{:g} k", value / 1e3);
  return value >= 100 ? fmt::format("{:.0f}", value) : fmt::format("{:.2g}", value);
}

std::string panel(const GrowthCurve& curve, double x, double y) {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const auto& point : curve.points)
    for (const Line& line : kLines) {
      least = std::min(least, point.cost.*line.cost);
      most = std::max(most, point.cost.*line.cost);
    }
  if (curve.points.empty() || !(least > 0.0)) return {};
  const double right = x + kPanelWidth - 12, bottom = y + kPanelHeight - kBelow;
  const LogAxis across = axis_over(curve.points.front().at, curve.points.back().at, x + kLeft, right);
  const LogAxis up = axis_over(std::pow(10.0, std::floor(std::log10(least))), most, bottom, y + kAbove);
  std::string svg =
      fmt::format("<text x='{:.0f}' y='{:.0f}' font-weight='bold'>over {}</text>\n", x + kLeft, y + 18, curve.over);
  for (double decade = std::ceil(up.lowest); decade <= up.highest; ++decade) {
    const double at = up.at(std::pow(10.0, decade));
    svg += fmt::format(
        "<line x1='{:.1f}' x2='{:.1f}' y1='{:.1f}' y2='{:.1f}' stroke='#ddd'/>"
        "<text x='{:.1f}' y='{:.1f}' text-anchor='end'>{}</text>\n",
        x + kLeft, right, at, at, x + kLeft - 6, at + 4, mark_text(std::pow(10.0, decade)));
  }
  for (const auto& point : curve.points)
    svg += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{}</text>\n", across.at(point.at), bottom + 18,
                       mark_text(point.at));
  for (const Line& line : kLines) {
    std::string path;
    for (const auto& point : curve.points) {
      const double px = across.at(point.at), py = up.at(point.cost.*line.cost);
      path += fmt::format("{:.1f},{:.1f} ", px, py);
      svg += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='3' fill='{}'/>\n", px, py, line.colour);
    }
    svg += fmt::format("<polyline points='{}' fill='none' stroke='{}' stroke-width='2'/>\n", path, line.colour);
  }
  return svg;
}

std::string plot(const std::vector<GrowthCurve>& curves) {
  const double rows = std::ceil(static_cast<double>(curves.size()) / 2.0), legend = 30;
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='{0:.0f}' height='{1:.0f}' viewBox='0 0 {0:.0f} {1:.0f}' "
      "font-family='sans-serif' font-size='12' fill='#222'>\n<rect width='100%' height='100%' fill='white'/>\n",
      2 * kPanelWidth, rows * kPanelHeight + legend);
  double x = kLeft;
  for (const Line& line : kLines) {
    svg += fmt::format("<rect x='{:.0f}' y='10' width='18' height='4' fill='{}'/><text x='{:.0f}' y='16'>{}</text>\n",
                       x, line.colour, x + 24, line.name);
    x += 220;
  }
  for (std::size_t i = 0; i < curves.size(); ++i)
    svg +=
        panel(curves[i], kPanelWidth * static_cast<double>(i % 2), legend + kPanelHeight * static_cast<double>(i / 2));
  return svg + "</svg>\n";
}

std::string csv(const std::vector<GrowthCurve>& curves) {
  std::string text = "over,at,picture_ms,pictures_per_s,over_blit,redraw_ms,model_mib,peak_mib\n";
  for (const auto& curve : curves)
    for (const auto& [at, size, cost] : curve.points)
      text += fmt::format("{},{:g},{:.3f},{:.1f},{:.3f},{:.2f},{:.2f},{:.1f}\n", curve.over, at, cost.picture_ms,
                          1e3 / cost.picture_ms, cost.over_blit, cost.redraw_ms, cost.model_mib, cost.peak_mib);
  return text;
}

}  // namespace

std::string growth_markdown(const std::vector<GrowthCurve>& curves) {
  std::string text =
      "| over | at | pictures/s | composite / blit | layer redrawn | model on the GPU | peak of the process |\n"
      "|---|---|---|---|---|---|---|\n";
  for (const auto& curve : curves)
    for (const auto& [at, size, cost] : curve.points)
      text += fmt::format("| {} | {} | {:.0f} | {:.2f} | {:.0f} ms | {:.1f} MiB | {:.0f} MiB |\n", curve.over,
                          mark_text(at), 1e3 / cost.picture_ms, cost.over_blit, cost.redraw_ms, cost.model_mib,
                          cost.peak_mib);
  return text;
}

Result<> write_growth(const std::filesystem::path& folder, const std::vector<GrowthCurve>& curves) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(FaultKind::io, "{}: cannot be made: {}", folder.string(), error.message());
  if (auto written = write_text_file(folder / "growth.csv", csv(curves)); !written) return written;
  return write_text_file(folder / "growth.svg", plot(curves));
}

}  // namespace kasumi
