#include "pipeline/lab/recording/air_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "base/utc_text.hpp"
#include "pipeline/show/scene/air_figures.hpp"

namespace kasumi {

namespace {

// Of the drawing, in its pixels.
constexpr double kWidth = 760.0, kHeight = 380.0, kLeft = 60.0, kRight = 20.0, kAbove = 44.0, kBelow = 40.0;

constexpr std::string_view kHead =
    "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" "
    "font-family=\"sans-serif\" font-size=\"12\" fill=\"#282828\">\n<rect width=\"{0}\" height=\"{1}\" "
    "fill=\"#ffffff\"/>\n";

// The observer behind a mark, and its colour.
constexpr std::array kMarks{std::pair{AirObserver::sky, std::string_view("#2850d2")},
                            std::pair{AirObserver::landmarks, std::string_view("#28963c")},
                            std::pair{AirObserver::horizon, std::string_view("#c87814")},
                            std::pair{AirObserver::remembered, std::string_view("#787878")}};

std::string_view colour_of(AirObserver by) {
  for (const auto& [observer, colour] : kMarks)
    if (observer == by) return colour;
  return "#282828";
}

// A step of the axis that people count in, some four to the top.
double step_below(double highest) {
  const double power = std::pow(10.0, std::floor(std::log10(highest / 4.0)));
  for (const double step : {5.0, 2.0, 1.0})
    if (step * power <= highest / 4.0 * 1.001) return step * power;
  return power;
}

// From time and amount to the drawing.
struct Axes {
  Utc first{};
  double span_s = 1.0, highest = 1.0;
  double x(Utc utc) const { return kLeft + (kWidth - kLeft - kRight) * to_seconds(utc - first) / span_s; }
  double y(double aod_550) const {
    return kHeight - kBelow - (kHeight - kAbove - kBelow) * std::clamp(aod_550 / highest, 0.0, 1.0);
  }
};

std::string frame_of(const Axes& axes, Utc last) {
  std::string text;
  const double step = step_below(axes.highest);
  for (double at = 0.0; at <= axes.highest * 1.001; at += step)
    text += fmt::format(
        "<line x1=\"{0:.1f}\" x2=\"{1:.1f}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\" stroke=\"#e1e1e1\"/>\n"
        "<text x=\"{3:.1f}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:.3g}</text>\n",
        kLeft, kWidth - kRight, axes.y(at), kLeft - 8.0, axes.y(at) + 4.0, at);
  const auto seconds = [](Utc utc) { return utc_text(std::chrono::floor<std::chrono::seconds>(utc)); };
  text += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", kLeft, kHeight - 14.0, seconds(axes.first));
  text += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", kWidth - kRight,
                      kHeight - 14.0, seconds(last));
  return text;
}

std::string legend() {
  std::string text = fmt::format(
      "<text x=\"{:.1f}\" y=\"22\">aerosol optical depth at 550 nm: the state and its sigma; alone: ", kLeft);
  for (const auto& [observer, colour] : kMarks)
    text += fmt::format("<tspan fill=\"{}\">&#9679; {}  </tspan>", colour, name_of(observer));
  return text + "</text>\n";
}

}  // namespace

void AirCurve::add(Utc utc, const TrackedAir& state) {
  Moment moment{utc, state.air.aerosol().aod_550, aod_sigma(state), state.supposed, {}};
  for (const ObserverPart& part : state.observers)
    if (part.age == Duration{0}) moment.readings.push_back({part.by, part.aod_550, part.sigma_aod_550});
  moments_.push_back(std::move(moment));
}

double AirCurve::highest() const {
  double highest = 0.02;
  for (const Moment& moment : moments_) {
    highest = std::max(highest, moment.aod_550 + moment.sigma);
    for (const Reading& reading : moment.readings) highest = std::max(highest, reading.aod_550);
  }
  return 1.1 * highest;
}

std::string AirCurve::svg() const {
  std::string text = fmt::format(kHead, kWidth, kHeight);
  if (moments_.empty()) return text + "</svg>\n";
  Axes axes{moments_.front().utc, to_seconds(moments_.back().utc - moments_.front().utc), highest()};
  if (axes.span_s <= 0.0) axes.span_s = 1.0;
  text += frame_of(axes, moments_.back().utc);
  std::string line;
  for (std::size_t i = 0; i < moments_.size(); ++i) {
    const Moment& now = moments_[i];
    line += fmt::format("{:.1f},{:.1f} ", axes.x(now.utc), axes.y(now.aod_550));
    if (i == 0) continue;
    const Moment& before = moments_[i - 1];
    text += fmt::format(
        "<polygon points=\"{0:.1f},{2:.1f} {0:.1f},{3:.1f} {1:.1f},{5:.1f} {1:.1f},{4:.1f}\" fill=\"{6}\"/>\n",
        axes.x(before.utc), axes.x(now.utc), axes.y(before.aod_550 - before.sigma),
        axes.y(before.aod_550 + before.sigma), axes.y(now.aod_550 - now.sigma), axes.y(now.aod_550 + now.sigma),
        now.supposed ? "#f0f0f0" : "#d2dcf0");
  }
  text += fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"#282828\" stroke-width=\"1.5\"/>\n", line);
  for (const Moment& moment : moments_)
    for (const Reading& reading : moment.readings) {
      const double x = axes.x(moment.utc);
      text += fmt::format(
          "<line x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.1f}\" y2=\"{2:.1f}\" stroke=\"{3}\" stroke-opacity=\".4\"/>\n"
          "<circle cx=\"{0:.1f}\" cy=\"{4:.1f}\" r=\"2.5\" fill=\"{3}\"/>\n",
          x, axes.y(reading.aod_550 - reading.sigma), axes.y(reading.aod_550 + reading.sigma), colour_of(reading.by),
          axes.y(reading.aod_550));
    }
  return text + legend() + "</svg>\n";
}

}  // namespace kasumi
