#include "history/history_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace kasumi {

namespace {

using std::chrono::minutes;

constexpr double kWidth = 720.0, kLeft = 56.0, kRight = 10.0;
constexpr double kStripTop = 22.0, kStripHeight = 30.0;
constexpr double kPanelHeight = 110.0, kPanelGap = 34.0;
constexpr double kHeight = kStripTop + kStripHeight + 2.0 * (kPanelHeight + kPanelGap) + 26.0;
constexpr std::string_view kInk = "#1b1b1b", kFaint = "#c9c9c9", kBand = "#bcd3ea", kLine = "#14507f";

struct StateLook {
  std::string_view colour;
  double height;  // of the strip
};

StateLook look_of(Shown shown) {
  switch (shown) {
    case Shown::live: return {"#2f7d4f", 1.0};
    case Shown::degraded: return {"#8fae3b", 0.8};
    case Shown::held: return {"#d9a21b", 0.6};
    case Shown::still: return {"#c4571c", 0.4};
    case Shown::nothing: return {"#a3122b", 0.25};
    case Shown::dark: return {"#5a5a6e", 0.12};
  }
  return {kFaint, 0.1};
}

class Plot {
 public:
  Plot(UtcMinute from, UtcMinute to, minutes wall) : from_(from), to_(std::max(to, from + minutes{1})), wall_(wall) {}

  double x(UtcMinute at) const {
    const double share = static_cast<double>((at - from_).count()) / static_cast<double>((to_ - from_).count());
    return kLeft + share * (kWidth - kLeft - kRight);
  }
  void add(std::string text) { text_ += text; }
  void label(double at_x, double at_y, std::string_view anchor, std::string_view words) {
    text_ += fmt::format(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="{}">{}</text>)"
                         "\n",
                         at_x, at_y, anchor, words);
  }
  // Of six steps at most.
  void hours(double top, double bottom) {
    constexpr std::array<long, 10> kSteps{5, 15, 30, 60, 120, 180, 360, 720, 1440, 2880};
    const auto length = (to_ - from_).count();
    const auto* step = std::ranges::find_if(kSteps, [&](long each) { return length / each <= 8; });
    // Years, where the clock was not set.
    const auto each = minutes{step == kSteps.end() ? (length / 8 / 1440 + 1) * 1440 : *step};
    const auto first = std::chrono::ceil<minutes>((from_ + wall_).time_since_epoch());
    for (auto at = (first + each - minutes{1}) / each * each; at <= (to_ + wall_).time_since_epoch(); at += each) {
      const auto utc = UtcMinute(at) - wall_;
      text_ += fmt::format("<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.1f}\" y2=\"{2:.1f}\" stroke=\"{3}\"/>\n",
                           x(utc), top, bottom, kFaint);
      const auto of_day = at % std::chrono::days{1};
      const auto words = each < minutes{1440}
                             ? fmt::format("{:02}:{:02}", of_day / minutes{60}, (of_day % minutes{60}).count())
                             : day_text(UtcMinute(at));
      label(x(utc), kHeight - 8.0, "middle", words);
    }
  }
  std::string whole(std::string_view title) const {
    return fmt::format(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{0}\" height=\"{1}\" role=\"img\" "
        "font-family=\"sans-serif\" font-size=\"12\" fill=\"{2}\">\n<title>{3}</title>\n"
        "<rect width=\"{0}\" height=\"{1}\" fill=\"#ffffff\"/>\n{4}</svg>\n",
        kWidth, kHeight, kInk, title, text_);
  }

 private:
  static std::string day_text(UtcMinute at) {
    const std::chrono::year_month_day day{std::chrono::floor<std::chrono::days>(at)};
    return fmt::format("{:02}-{:02}", static_cast<unsigned>(day.month()), static_cast<unsigned>(day.day()));
  }
  UtcMinute from_, to_;
  minutes wall_;
  std::string text_;
};

void draw_strip(const std::vector<Spell>& spells, std::string_view words, Plot& plot) {
  plot.label(kLeft, kStripTop - 7.0, "start", words);
  for (const auto& spell : spells) {
    if (!spell.told) continue;
    const auto [colour, share] = look_of(spell.shown);
    const double left = plot.x(spell.from), right = plot.x(spell.to + minutes{1});
    plot.add(fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n", left,
                         kStripTop + (1.0 - share) * kStripHeight, std::max(0.6, right - left), share * kStripHeight,
                         colour));
  }
  plot.add(fmt::format("<line x1=\"{}\" x2=\"{}\" y1=\"{}\" y2=\"{}\" stroke=\"{}\"/>\n", kLeft, kWidth - kRight,
                       kStripTop + kStripHeight, kStripTop + kStripHeight, kInk));
}

struct Figure {
  std::optional<double> value, sigma;
};

// About `about` even steps.
double step_of(double range, int about) {
  const double raw = range / about, power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double each : {1.0, 2.0, 5.0})
    if (each * power >= raw) return each * power;
  return 10.0 * power;
}

template <class FigureOf>
void draw_panel(const std::vector<HistoryLine>& lines, double top, std::string_view words, std::string_view none,
                FigureOf figure_of, Plot& plot) {
  const double bottom = top + kPanelHeight;
  plot.label(kLeft, top - 7.0, "start", words);
  double lowest = 1e9, highest = -1e9;
  for (const auto& line : lines) {
    const Figure figure = figure_of(line);
    if (!figure.value) continue;
    lowest = std::min(lowest, *figure.value - figure.sigma.value_or(0.0));
    highest = std::max(highest, *figure.value + figure.sigma.value_or(0.0));
  }
  plot.add(fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"{}\"/>\n", kLeft, top,
                       kWidth - kLeft - kRight, kPanelHeight, kFaint));
  if (lowest > highest) return plot.label(0.5 * (kLeft + kWidth), 0.5 * (top + bottom), "middle", none);
  const double margin = std::max(0.08 * (highest - lowest), 0.02 * std::max(std::abs(highest), 0.01));
  lowest = std::max(0.0, lowest - margin);
  highest += margin;
  const auto y = [&](double value) {
    return bottom - (std::clamp(value, lowest, highest) - lowest) / (highest - lowest) * kPanelHeight;
  };
  const double step = step_of(highest - lowest, 4);
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  for (double tick = std::ceil(lowest / step) * step; tick <= highest + 1e-9; tick += step) {
    plot.add(fmt::format("<line x1=\"{}\" x2=\"{}\" y1=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"/>\n", kLeft,
                         kWidth - kRight, y(tick), y(tick), kFaint));
    plot.label(kLeft - 6.0, y(tick) + 4.0, "end", fmt::format("{:.{}f}", tick, decimals));
  }
  // Pieces without a gap: a band of one sigma, and the line within.
  std::string upper, lower, middle;
  const auto flush = [&] {
    if (middle.empty()) return;
    plot.add(
        fmt::format("<polygon points=\"{}{}\" fill=\"{}\"/>\n<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" "
                    "stroke-width=\"1.5\"/>\n",
                    upper, lower, kBand, middle, kLine));
    upper = lower = middle = "";
  };
  UtcMinute before{};
  for (const auto& line : lines) {
    const Figure figure = figure_of(line);
    if (!figure.value || line.utc - before > minutes{5} || line.utc < before) flush();
    before = line.utc;
    if (!figure.value) continue;
    const double at = plot.x(line.utc), sigma = figure.sigma.value_or(0.0);
    upper += fmt::format("{:.1f},{:.1f} ", at, y(*figure.value + sigma));
    lower = fmt::format("{:.1f},{:.1f} ", at, y(*figure.value - sigma)) + lower;
    middle += fmt::format("{:.1f},{:.1f} ", at, y(*figure.value));
  }
  flush();
}

}  // namespace

std::string history_plot(const std::vector<HistoryLine>& lines, UtcMinute from, UtcMinute to, minutes wall,
                         const PlotWords& words) {
  std::vector<HistoryLine> within;
  for (const auto& line : lines)
    if (line.utc >= from && line.utc <= to) within.push_back(line);
  // More points than pixels would show nothing more.
  const std::size_t every = std::max<std::size_t>(1, within.size() / 720);
  std::vector<HistoryLine> thinned;
  for (std::size_t i = 0; i < within.size(); i += every) thinned.push_back(within[i]);

  Plot plot(from, to, wall);
  constexpr double kFirst = kStripTop + kStripHeight + kPanelGap, kSecond = kFirst + kPanelHeight + kPanelGap;
  plot.hours(kStripTop, kSecond + kPanelHeight);
  draw_strip(spells_of(within), words.seen, plot);
  draw_panel(
      thinned, kFirst, words.turbidity, words.none,
      [](const HistoryLine& line) {
        return Figure{line.turbidity, line.sigma_turbidity};
      },
      plot);
  draw_panel(
      thinned, kSecond, words.aod, words.none,
      [](const HistoryLine& line) {
        return Figure{line.aod_550, line.sigma_aod_550};
      },
      plot);
  return plot.whole(words.title);
}

}  // namespace kasumi
