#include "pipeline/lab/archive/archive_plots.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/lab/archive/svg_shapes.hpp"

namespace kasumi {
namespace {

using std::chrono::days;
using std::chrono::sys_days;
using std::chrono::year_month_day;

constexpr std::string_view kMissing = "#f1f1f1";
constexpr std::array<const char*, 12> kMonths{"Jan", "Feb", "Mar", "Apr", "May", "Jun",
                                              "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};

std::string_view name_of_figure(ArchiveFigure figure) {
  return figure == ArchiveFigure::aod ? "aerosol optical depth at 550 nm" : "share of the sky that is cloud";
}

std::optional<double> value_of(const Cell& cell, ArchiveFigure figure) {
  if (figure == ArchiveFigure::cloud) return cell.cloud();
  const auto spread = cell.aod();
  return spread ? std::optional(spread->median) : std::nullopt;
}

// The top of a scale of such values: of aerosol a few hazy days may be off it.
double top_of(std::vector<double> values, ArchiveFigure figure) {
  if (figure == ArchiveFigure::cloud) return 1.0;
  if (values.empty()) return 0.5;
  std::ranges::sort(values);
  const double most =
      std::max(0.05, values[static_cast<std::size_t>(0.98 * static_cast<double>(values.size() - 1) + 0.5)]);
  const double step = round_step(most);
  return std::ceil(most / step - 1e-9) * step;
}

std::vector<double> daily_values(const ArchiveFigures& figures, ArchiveFigure figure) {
  std::vector<double> values;
  for (const auto& [_, cell] : figures.days())
    if (const auto value = value_of(cell, figure)) values.push_back(*value);
  return values;
}

// Light to dark, so that it reads on grey paper, too: sand to violet of aerosol, blue sky to grey of cloud.
std::string colour_of(double share, ArchiveFigure figure) {
  using Rgb = std::array<double, 3>;
  static constexpr std::array kAerosol{Rgb{255, 244, 214}, Rgb{246, 190, 120}, Rgb{219, 112, 92}, Rgb{150, 50, 105},
                                       Rgb{62, 18, 82}};
  static constexpr std::array kCloud{Rgb{226, 240, 252}, Rgb{160, 200, 232}, Rgb{118, 150, 182}, Rgb{84, 100, 122},
                                     Rgb{40, 46, 58}};
  const auto& scale = figure == ArchiveFigure::aod ? kAerosol : kCloud;
  const double at = std::clamp(share, 0.0, 1.0) * static_cast<double>(scale.size() - 1);
  const auto below = std::min(scale.size() - 2, static_cast<std::size_t>(at));
  const double part = at - static_cast<double>(below);
  const auto mixed = [&](std::size_t c) {
    return static_cast<int>(std::lround((1.0 - part) * scale[below][c] + part * scale[below + 1][c]));
  };
  return fmt::format("#{:02x}{:02x}{:02x}", mixed(0), mixed(1), mixed(2));
}

void add_scale(PageText& svg, double x, double y, double top, ArchiveFigure figure) {
  constexpr int kSteps = 30;
  constexpr double kStep = 5.0;
  add_text(svg, x - 6, y + 11, "end", "0");
  for (int i = 0; i < kSteps; ++i)
    svg.add("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"14\" fill=\"{}\"/>\n", x + kStep * i, y, kStep + 0.5,
            colour_of((i + 0.5) / kSteps, figure));
  add_text(svg, x + kStep * kSteps + 6, y + 11, "start",
           figure == ArchiveFigure::aod ? fmt::format("{:g} or more", top) : fmt::format("{:g}", top));
  svg.add("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"14\" height=\"14\" fill=\"{}\" stroke=\"{}\"/>\n", x + 270, y,
          kMissing, kPlotPale);
  add_text(svg, x + 290, y + 11, "start", "not known");
}

std::string day_name(sys_days day) {
  const year_month_day date{day};
  return fmt::format("{:04}-{:02}-{:02}", static_cast<int>(date.year()), static_cast<unsigned>(date.month()),
                     static_cast<unsigned>(date.day()));
}

sys_days next_month(sys_days day) {
  const year_month_day date{day};
  return sys_days{(date.year() / date.month() + std::chrono::months{1}) / std::chrono::day{1}};
}

// Dates over an axis: months, or years where months would stand too close.
class Dates {
 public:
  Dates(sys_days first, sys_days last, double left, double right)
      : first_(first), count_(static_cast<double>((last - first).count() + 1)), left_(left), right_(right) {}
  double x(sys_days day) const { return left_ + (static_cast<double>((day - first_).count()) + 0.5) * pitch(); }
  double pitch() const { return (right_ - left_) / count_; }
  void add_ticks(PageText& svg, double top, double bottom) const {
    const double months = count_ / 30.4;
    const unsigned each = months <= 14 ? 1 : months <= 40 ? 3 : 12;
    double before = -1e9;
    const auto tick = [&](sys_days day, const std::string& words) {
      const double at = x(day) - 0.5 * pitch();
      add_rule(svg, at, top, at, bottom);
      if (at - before < 44.0 || at > right_ - 26.0) return;
      before = at;
      add_text(svg, at, bottom + 16, "start", words);
    };
    if (months < 1.0) {
      const auto step = std::max(1, static_cast<int>(count_ / 10.0));
      for (int i = 0; i < static_cast<int>(count_); i += step)
        tick(first_ + days{i}, day_name(first_ + days{i}).substr(5));
      return;
    }
    const auto last = first_ + days{static_cast<int>(count_)};
    for (auto day = next_month(first_ - days{1}); day < last; day = next_month(day)) {
      const year_month_day date{day};
      const auto month = static_cast<unsigned>(date.month()) - 1;
      if (month % each != 0) continue;
      tick(day, month == 0 ? fmt::format("{}", static_cast<int>(date.year())) : kMonths[month]);
    }
  }

 private:
  sys_days first_;
  double count_, left_, right_;
};

}  // namespace

std::string plot_by_day(const ArchiveFigures& figures, ArchiveFigure figure) {
  constexpr double kWidth = 960, kHeight = 250, kLeft = 46, kRight = 950, kTop = 14, kBottom = 222;
  PageText svg;
  open_svg(svg, kWidth, kHeight, fmt::format("By day: {}", name_of_figure(figure)));
  const double top = top_of(daily_values(figures, figure), figure), step = round_step(top);
  const auto y = [&](double value) { return kBottom - std::clamp(value / top, 0.0, 1.0) * (kBottom - kTop); };
  for (double v = 0.0; v <= top + 1e-9; v += step) {
    add_rule(svg, kLeft, y(v), kRight, y(v));
    add_text(svg, kLeft - 6, y(v) + 4, "end", fmt::format("{:g}", std::round(v * 1e6) / 1e6));
  }
  const auto& all = figures.days();
  const Dates dates(all.begin()->first, all.rbegin()->first, kLeft, kRight);
  dates.add_ticks(svg, kTop, kBottom);
  const double wide = std::clamp(0.8 * dates.pitch(), 0.6, 12.0);
  for (const auto& [day, cell] : all) {
    const double x = dates.x(day);
    if (figure == ArchiveFigure::cloud) {
      const auto share = cell.cloud();
      if (share)
        add_square(svg, x - 0.5 * wide, y(*share), wide, kBottom - y(*share), colour_of(0.45, figure),
                   fmt::format("{}: {:.0f} % of {} skies", day_name(day), 100.0 * *share, cell.clouds()));
      continue;
    }
    const auto spread = cell.aod();
    if (!spread) continue;
    const auto says = fmt::format("{}: {:.3f} ({:.3f} to {:.3f}), {} pictures", day_name(day), spread->median,
                                  spread->low, spread->high, cell.aods());
    add_square(svg, x - 0.5 * wide, y(spread->high), wide, std::max(0.5, y(spread->low) - y(spread->high)), "#e8b48c",
               says);
    add_square(svg, x - 0.5 * wide, y(spread->median) - 1.2, wide, 2.4, "#7a1f5c", says);
  }
  svg.add("</svg>\n");
  return std::move(svg).text();
}

std::string plot_calendar(const ArchiveFigures& figures, ArchiveFigure figure) {
  constexpr double kSide = 16, kPitch = 17, kLeft = 46, kBlock = 7 * kPitch + 26;
  const auto& all = figures.days();
  const int first = static_cast<int>(year_month_day(all.begin()->first).year());
  const int last = static_cast<int>(year_month_day(all.rbegin()->first).year());
  const double top = top_of(daily_values(figures, figure), figure);
  const double height = kBlock * (last - first + 1) + 24;
  PageText svg;
  open_svg(svg, 960, height, fmt::format("Calendar: {}", name_of_figure(figure)));
  for (int year = first; year <= last; ++year) {
    const double above = kBlock * (year - first) + 18;
    const sys_days begin{std::chrono::year{year} / 1 / 1}, end{std::chrono::year{year + 1} / 1 / 1};
    const int offset = static_cast<int>(std::chrono::weekday(begin).iso_encoding()) - 1;
    add_text(svg, kLeft - 8, above + 3.5 * kPitch, "end", fmt::format("{}", year), kPlotDark);
    for (auto day = begin; day < end; day += days{1}) {
      const int n = static_cast<int>((day - begin).count()) + offset;
      const double x = kLeft + kPitch * (n / 7), y = above + kPitch * (n % 7);
      const year_month_day date{day};
      if (static_cast<unsigned>(date.day()) == 1)
        add_text(svg, x, above - 5, "start", kMonths[static_cast<unsigned>(date.month()) - 1]);
      const auto found = all.find(day);
      const auto value = found != all.end() ? value_of(found->second, figure) : std::nullopt;
      if (found == all.end()) continue;  // no picture
      add_square(svg, x, y, kSide, kSide, value ? colour_of(*value / top, figure) : std::string(kMissing),
                 value ? fmt::format("{}: {:.3f}", day_name(day), *value) : day_name(day) + ": not known");
    }
  }
  add_scale(svg, kLeft + 14, height - 20, top, figure);
  svg.add("</svg>\n");
  return std::move(svg).text();
}

std::string plot_by_hour_and_month(const ArchiveFigures& figures, ArchiveFigure figure) {
  constexpr double kWide = 36, kHigh = 20, kLeft = 46, kTop = 20, kHeight = kTop + 12 * kHigh + 32;
  std::vector<double> values;
  for (std::size_t month = 0; month < 12; ++month)
    for (std::size_t hour = 0; hour < 24; ++hour)
      if (const auto value = value_of(figures.at(month, hour), figure)) values.push_back(*value);
  const double top = top_of(values, figure);
  PageText svg;
  open_svg(svg, 960, kHeight, fmt::format("By hour and month: {}", name_of_figure(figure)));
  for (int hour = 0; hour <= 24; hour += 3)
    add_text(svg, kLeft + kWide * hour, kTop - 6, "middle", fmt::format("{:02}:00", hour));
  for (std::size_t month = 0; month < 12; ++month) {
    const double y = kTop + kHigh * static_cast<double>(month);
    add_text(svg, kLeft - 8, y + 14, "end", kMonths[month]);
    for (std::size_t hour = 0; hour < 24; ++hour) {
      const auto& cell = figures.at(month, hour);
      if (cell.pictures() == 0) continue;
      const auto value = value_of(cell, figure);
      const auto count = figure == ArchiveFigure::aod ? cell.aods() : cell.clouds();
      add_square(svg, kLeft + kWide * static_cast<double>(hour), y, kWide - 1, kHigh - 1,
                 value ? colour_of(*value / top, figure) : std::string(kMissing),
                 value ? fmt::format("{} {:02}:00: {:.3f}, {} pictures", kMonths[month], hour, *value, count)
                       : fmt::format("{} {:02}:00: not known, {} pictures", kMonths[month], hour, cell.pictures()));
    }
  }
  add_scale(svg, kLeft + 14, kTop + 12 * kHigh + 12, top, figure);
  svg.add("</svg>\n");
  return std::move(svg).text();
}

std::string plot_suns(const ArchiveFigures& figures) {
  constexpr double kWide = 36, kHigh = 20, kLeft = 46, kTop = 20, kBottom = kTop + 9 * kHigh;
  constexpr std::array<const char*, 5> kSides{"N", "E", "S", "W", "N"};
  std::size_t most = 1;
  for (std::size_t height = 0; height < 9; ++height)
    for (std::size_t azimuth = 0; azimuth < 24; ++azimuth) most = std::max(most, figures.suns(height, azimuth));
  PageText svg;
  open_svg(svg, 960, kBottom + 40, "Where the sun stood when the air was known");
  for (std::size_t i = 0; i < kSides.size(); ++i)
    add_text(svg, kLeft + kWide * 6.0 * static_cast<double>(i), kTop - 6, "middle", kSides[i]);
  for (std::size_t height = 0; height < 9; ++height) {
    const double y = kBottom - kHigh * static_cast<double>(height + 1);
    add_text(svg, kLeft - 8, y + kHigh + 4, "end", fmt::format("{}\u00b0", 10 * height));
    for (std::size_t azimuth = 0; azimuth < 24; ++azimuth) {
      const auto count = figures.suns(height, azimuth);
      const auto colour =
          colour_of(std::sqrt(static_cast<double>(count) / static_cast<double>(most)), ArchiveFigure::aod);
      add_square(svg, kLeft + kWide * static_cast<double>(azimuth), y, kWide - 1, kHigh - 1,
                 count > 0 ? colour : std::string(kMissing),
                 fmt::format("azimuth {} to {}, height {} to {} degrees: {} pictures", 15 * azimuth, 15 * azimuth + 15,
                             10 * height, 10 * height + 10, count));
    }
  }
  add_text(svg, kLeft, kBottom + 28, "start", fmt::format("darkest: {} pictures; pale grey: none", most));
  svg.add("</svg>\n");
  return std::move(svg).text();
}

std::string plot_refusals(const ArchiveFigures& figures) {
  constexpr std::size_t kMost = 12;
  constexpr double kRow = 24, kBar = 380;
  auto reasons = figures.refusals();
  if (reasons.size() > kMost) {
    std::size_t rest = 0;
    for (std::size_t i = kMost - 1; i < reasons.size(); ++i) rest += reasons[i].second;
    reasons.resize(kMost - 1);
    reasons.emplace_back("other reasons", rest);
  }
  PageText svg;
  open_svg(svg, 960, kRow * static_cast<double>(reasons.size()) + 6,
           "Share of the pictures that were refused, by reason");
  for (std::size_t i = 0; i < reasons.size(); ++i) {
    const double y = kRow * static_cast<double>(i) + 4;
    const double share = static_cast<double>(reasons[i].second) / static_cast<double>(figures.pictures());
    svg.add("<rect x=\"1\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:g}\" fill=\"#7696b6\"/>\n", y,
            std::max(1.0, kBar * share), kRow - 8);
    auto words = reasons[i].first;
    constexpr std::size_t kLongest = 72;
    if (words.size() > kLongest) words = words.substr(0, words.find_last_of(' ', kLongest)) + " ...";
    add_text(svg, kBar * share + 8, y + 12, "start", fmt::format("{:.1f} %, {}", 100.0 * share, words), kPlotDark);
  }
  svg.add("</svg>\n");
  return std::move(svg).text();
}

}  // namespace kasumi
