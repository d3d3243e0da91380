#include "pipeline/lab/prove/proof_plots.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace kasumi {
namespace {

constexpr int kWidth = 640, kHeight = 360, kLeft = 56, kRight = 16, kTop = 16, kBottom = 44;
constexpr const char* kInks[] = {"#c82828", "#28963c", "#2850d2"};
constexpr const char *kToldInk = "#222222", *kNoAirInk = "#2850d2", *kFixedInk = "#c88000";

struct Axis {
  double least = 0.0, most = 1.0, step = 1.0;
  std::string title;
  bool logarithmic = false;
  double share(double value) const {
    const double at = logarithmic ? std::log(std::max(value, 1e-9) / least) / std::log(most / least)
                                  : (value - least) / (most - least);
    return std::clamp(at, 0.0, 1.0);
  }
};

class Plot {
 public:
  Plot(Axis across, Axis up) : across_(std::move(across)), up_(std::move(up)) {
    text_ =
        fmt::format("<svg viewBox=\"0 0 {} {}\" role=\"img\" font-family=\"system-ui, sans-serif\" font-size=\"12\">\n",
                    kWidth, kHeight);
    for (double v = up_.least; v <= up_.most + 1e-9; v += up_.step) {
      add_line(kLeft, y(v), kWidth - kRight, y(v), "#e0e0e0");
      text_ += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\" fill=\"#555\">{:g}</text>\n", kLeft - 6,
                           y(v) + 4, v);
    }
    for (double v = across_.least; v <= across_.most * (1.0 + 1e-9);
         v = across_.logarithmic ? v * across_.step : v + across_.step) {
      add_line(x(v), kTop, x(v), kHeight - kBottom, "#e0e0e0");
      text_ += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\" fill=\"#555\">{:g}</text>\n", x(v),
                           kHeight - kBottom + 16, v);
    }
    text_ += fmt::format("<text x=\"{}\" y=\"{}\" text-anchor=\"middle\" fill=\"#222\">{}</text>\n",
                         (kLeft + kWidth - kRight) / 2, kHeight - 8, across_.title);
    text_ += fmt::format(
        "<text x=\"14\" y=\"{0}\" text-anchor=\"middle\" fill=\"#222\" transform=\"rotate(-90 14 {0})\">{1}</text>\n",
        (kTop + kHeight - kBottom) / 2, up_.title);
  }
  void add_point(double across, double up, const char* ink) {
    text_ += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"2.5\" fill=\"{}\" fill-opacity=\".55\"/>\n",
                         x(across), y(up), ink);
  }
  void add_straight(double x0, double y0, double x1, double y1, const char* ink) {
    add_line(x(x0), y(y0), x(x1), y(y1), ink);
  }
  void add_name(int row, std::string_view name, const char* ink) {
    const int at = kTop + 14 + 16 * row;
    text_ += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"4\" fill=\"{}\"/><text x=\"{}\" y=\"{}\">{}</text>\n",
                         kLeft + 14, at - 4, ink, kLeft + 24, at, name);
  }
  std::string text() && { return std::move(text_) + "</svg>\n"; }

 private:
  double x(double value) const { return kLeft + across_.share(value) * (kWidth - kLeft - kRight); }
  double y(double value) const { return kHeight - kBottom - up_.share(value) * (kHeight - kTop - kBottom); }
  void add_line(double x0, double y0, double x1, double y1, const char* ink) {
    text_ += fmt::format("<line x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\" stroke=\"{}\"/>\n", x0, y0, x1,
                         y1, ink);
  }
  Axis across_, up_;
  std::string text_;
};

Axis levels_axis(const char* title) {
  return {0.0, 250.0, 50.0, title};
}

}  // namespace

std::string plot_drawn_over_seen(const Proof& proof) {
  Plot plot(levels_axis("as the camera saw it, of 255"), levels_axis("as drawn"));
  plot.add_straight(0, 0, 250, 250, "#888888");
  for (const auto& picture : proof.pictures)
    for (int c = 0; c < 3 && picture.judged(); ++c)
      plot.add_point(picture.seen_255[c], picture.drawn_by(ProofWay::told)[c], kInks[c]);
  plot.add_name(0, "red", kInks[0]);
  plot.add_name(1, "green", kInks[1]);
  plot.add_name(2, "blue", kInks[2]);
  return std::move(plot).text();
}

std::string plot_errors_over_extinction(const Proof& proof) {
  Plot plot({0.01, 1.28, 2.0, "extinction told, green, per km", true}, {0.0, 120.0, 20.0, "off, of 255"});
  for (const auto& picture : proof.pictures) {
    if (!picture.judged()) continue;
    const double per_km = 1e3 * picture.air.per_m.g;
    plot.add_point(per_km, picture.error_255(ProofWay::no_air), kNoAirInk);
    plot.add_point(per_km, picture.error_255(ProofWay::fixed_t), kFixedInk);
    plot.add_point(per_km, picture.error_255(ProofWay::told), kToldInk);
  }
  plot.add_name(0, "under the air told", kToldInk);
  plot.add_name(1, "under T = 3", kFixedInk);
  plot.add_name(2, "without air", kNoAirInk);
  return std::move(plot).text();
}

std::string plot_over_time(const Proof& proof) {
  const double count = static_cast<double>(std::max<std::size_t>(2, proof.pictures.size()));
  const double step = std::max(1.0, std::pow(10.0, std::floor(std::log10(count / 3.0))));
  Plot plot({0.0, count, count / step > 12.0 ? 5.0 * step : step, "picture, in order of time"},
            levels_axis("green, of 255"));
  for (std::size_t i = 0; i < proof.pictures.size(); ++i) {
    const auto& picture = proof.pictures[i];
    if (!picture.judged()) continue;
    const double at = static_cast<double>(i), is = picture.drawn_by(ProofWay::told).g;
    plot.add_straight(at, is - picture.sigma_255.g, at, is + picture.sigma_255.g, "#a0d0a8");
    plot.add_point(at, is, kInks[1]);
    plot.add_point(at, picture.seen_255.g, kToldInk);
  }
  plot.add_name(0, "as seen", kToldInk);
  plot.add_name(1, "as drawn, with its sigma", kInks[1]);
  return std::move(plot).text();
}

}  // namespace kasumi
