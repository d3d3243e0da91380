#include "pipeline/lab/archive/series_plots.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/lab/archive/svg_shapes.hpp"

namespace kasumi {
namespace {

constexpr double kFrameLeft = 60, kFrameRight = 950, kFrameTop = 14, kFrameBottom = 192, kFrameHeight = 220;
constexpr std::string_view kValueInk = "#7a1f5c", kLineInk = "#23588a";

std::string month_name(int month) {
  return fmt::format("{:04}-{:02}", month / 12, month % 12 + 1);
}

// An axis of months across, one of values up.
class MonthAxes {
 public:
  MonthAxes(PageText& svg, int first, int last, double low, double high)
      : first_(first),
        months_(last - first + 1),
        step_(round_step(std::max(high - low, 0.02 * std::max(1.0, std::abs(high))))) {
    low_ = std::floor(low / step_ + 1e-9) * step_;
    high_ = std::max(std::ceil(high / step_ - 1e-9) * step_, low_ + step_);
    for (double v = low_; v <= high_ + 1e-9; v += step_) {
      add_rule(svg, kFrameLeft, y(v), kFrameRight, y(v));
      add_text(svg, kFrameLeft - 6, y(v) + 4, "end", fmt::format("{:g}", std::round(v * 1e6) / 1e6));
    }
    const int each = months_ <= 14 ? 1 : months_ <= 40 ? 3 : 12 * std::max(1, months_ / 240);
    for (int month = first; month <= last; ++month) {
      if (month % each != 0) continue;
      const double at = x(month) - 0.5 * pitch();
      add_rule(svg, at, kFrameTop, at, kFrameBottom);
      add_text(svg, at, kFrameBottom + 16, "start", each % 12 == 0 ? fmt::format("{}", month / 12) : month_name(month));
    }
  }
  double x(double month) const { return kFrameLeft + (month - first_ + 0.5) * pitch(); }
  double y(double value) const {
    return kFrameBottom - std::clamp((value - low_) / (high_ - low_), 0.0, 1.0) * (kFrameBottom - kFrameTop);
  }
  double pitch() const { return (kFrameRight - kFrameLeft) / months_; }

 private:
  int first_, months_;
  double step_, low_ = 0.0, high_ = 1.0;
};

void add_dot(PageText& svg, double x, double y, double radius, const std::string& says) {
  svg.add("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:g}\" fill=\"{}\"><title>{}</title></circle>\n", x, y, radius,
          kValueInk, html_escaped(says));
}

}  // namespace

std::string plot_trend(const std::vector<MonthlyValue>& values, const Trend& trend) {
  const auto most = std::ranges::max(values, {}, &MonthlyValue::value).value;
  const int first = values.front().month, last = values.back().month;
  PageText svg;
  open_svg(svg, 960, kFrameHeight, "By month: aerosol optical depth at 550 nm, and its trend");
  const MonthAxes axes(svg, first, last, 0.0, most);
  for (const auto& [month, value] : values)
    add_dot(svg, axes.x(month), axes.y(value), 3, fmt::format("{}: {:.3f}", month_name(month), value));
  svg.add("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"2\"/>\n</svg>\n",
          axes.x(first), axes.y(trend.at(first)), axes.x(last), axes.y(trend.at(last)), kLineInk);
  return std::move(svg).text();
}

std::string plot_fates(const SeriesFigures& series) {
  struct Kind {
    EstimateFate fate;
    std::string_view colour;
  };
  constexpr std::array<Kind, kSkyFates> kKinds{{{EstimateFate::air_known, "#d98a3d"},
                                                {EstimateFate::cloudy, "#8fb0cf"},
                                                {EstimateFate::sun_too_low, "#e9d9a8"},
                                                {EstimateFate::other, "#a3a3a3"},
                                                {EstimateFate::night, "#2b3a55"}}};
  const auto& months = series.months();
  PageText svg;
  open_svg(svg, 960, kFrameHeight + 24, "By month: what became of the pictures");
  const MonthAxes axes(svg, months.begin()->first, months.rbegin()->first, 0.0, 1.0);
  const double wide = std::clamp(0.85 * axes.pitch(), 0.6, 40.0);
  for (const auto& [number, month] : months) {
    const auto all = static_cast<double>(month.pictures());
    double below = 0.0;
    for (const auto& kind : kKinds) {
      const double share = static_cast<double>(month.count(kind.fate)) / all;
      if (share > 0.0)
        add_square(svg, axes.x(number) - 0.5 * wide, axes.y(below + share), wide, axes.y(below) - axes.y(below + share),
                   kind.colour, fmt::format("{}: {:.1f} % {}", month_name(number), 100.0 * share, name_of(kind.fate)));
      below += share;
    }
  }
  double x = kFrameLeft;
  for (const auto& kind : kKinds) {
    svg.add("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"14\" height=\"14\" fill=\"{}\"/>\n", x, kFrameHeight + 2,
            kind.colour);
    add_text(svg, x + 20, kFrameHeight + 13, "start", name_of(kind.fate));
    x += 40.0 + 7.2 * static_cast<double>(name_of(kind.fate).size());
  }
  svg.add("</svg>\n");
  return std::move(svg).text();
}

std::string plot_drift(const SeriesFigures& series, const std::string& title,
                       const std::function<std::optional<double>(const MonthlyTally&)>& value) {
  std::vector<MonthlyValue> values;
  for (const auto& [number, month] : series.months())
    if (const auto known = value(month)) values.push_back({number, *known});
  if (values.size() < 2) return {};
  const auto [least, most] = std::ranges::minmax(values, {}, &MonthlyValue::value);
  PageText svg;
  open_svg(svg, 960, kFrameHeight, "By month: " + title);
  const MonthAxes axes(svg, series.months().begin()->first, series.months().rbegin()->first, least.value, most.value);
  for (const auto& [month, each] : values)
    add_dot(svg, axes.x(month), axes.y(each), 3, fmt::format("{}: {:.2f}", month_name(month), each));
  svg.add("</svg>\n");
  return std::move(svg).text();
}

std::string plot_agreement(const PhotometerComparison& comparison) {
  constexpr std::size_t kMostDots = 4000;  // a page is to be opened
  constexpr double kHeight = 340, kBottom = 290;
  const auto& pairs = comparison.pairs();
  const auto all = comparison.agreement();
  double most = 0.1, widest = std::max(0.05, std::abs(all.bias) + 1.96 * all.scatter);
  std::vector<std::pair<double, double>> dots;
  const std::size_t step = (pairs.size() + kMostDots - 1) / kMostDots;
  for (std::size_t i = 0; i < pairs.size(); i += step) {
    const double camera = double{pairs[i].camera}, photometer = double{pairs[i].photometer};
    dots.emplace_back(0.5 * (camera + photometer), camera - photometer);
    most = std::max(most, dots.back().first);
    widest = std::max(widest, std::abs(dots.back().second));
  }
  const auto x = [&](double mean) { return kFrameLeft + mean / most * (kFrameRight - kFrameLeft); };
  const auto y = [&](double off) { return 0.5 * (kFrameTop + kBottom) - off / widest * 0.5 * (kBottom - kFrameTop); };
  PageText svg;
  open_svg(svg, 960, kHeight, "Camera less photometer over the mean of both, aerosol optical depth at 550 nm");
  const double across = round_step(most), up = round_step(2.0 * widest);
  for (double v = 0.0; v <= most + 1e-9; v += across) {
    add_rule(svg, x(v), kFrameTop, x(v), kBottom);
    add_text(svg, x(v), kBottom + 16, "middle", fmt::format("{:g}", std::round(v * 1e6) / 1e6));
  }
  for (double v = -std::floor(widest / up) * up; v <= widest + 1e-9; v += up) {
    add_rule(svg, kFrameLeft, y(v), kFrameRight, y(v));
    add_text(svg, kFrameLeft - 6, y(v) + 4, "end", fmt::format("{:g}", std::round(v * 1e6) / 1e6));
  }
  add_text(svg, kFrameRight, kBottom + 34, "end", "mean of camera and photometer");
  for (const auto& [mean, off] : dots) add_dot(svg, x(mean), y(off), 2, fmt::format("{:+.3f} at {:.3f}", off, mean));
  for (const double limit : {-1.96, 0.0, 1.96}) {
    const double at = y(all.bias + limit * all.scatter);
    svg.add("<line x1=\"{:g}\" y1=\"{:.1f}\" x2=\"{:g}\" y2=\"{:.1f}\" stroke=\"{}\" stroke-width=\"2\"{}/>\n",
            kFrameLeft, at, kFrameRight, at, kLineInk, limit == 0.0 ? "" : " stroke-dasharray=\"6 4\"");
  }
  svg.add("</svg>\n");
  return std::move(svg).text();
}

}  // namespace kasumi
