#include "pipeline/install/calibration_report/plots.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "calib/light/response_levels.hpp"
#include "pipeline/install/calibration_report/plot_style.hpp"

namespace kasumi {

namespace {

constexpr double kStops = 10.0;
const std::array kChannelDots{cv::Scalar(240, 190, 190), cv::Scalar(190, 225, 195), cv::Scalar(190, 205, 240)};

// Light of a pixel from the whole stack, in the unit of exposure 1.
double light_of(const StackSamples& samples, const ResponseFit& fit, int channel, std::size_t pixel) {
  double sum = 0.0, weights = 0.0;
  const auto& curve = fit.light[static_cast<std::size_t>(channel)];
  for (std::size_t j = 0; j < samples.exposures; ++j) {
    const double value = samples.at(channel, pixel, j);
    if (value < 2.0 * samples.quantum || value >= kSaturated) continue;
    const double s = std::exp(fit.log_s[j]), slope = std::max(1e-6, slope_at(curve, value));
    sum += s / (slope * slope) * light_at(curve, value);
    weights += s * s / (slope * slope);
  }
  return weights > 0.0 ? sum / weights : 0.0;
}

}  // namespace

Image<Rgb8> plot_response(const ResponseFit& fit, const StackSamples& samples, const std::string& title) {
  Image<Rgb8> image(2 * kPanelSide + 3 * kPanelMargin, kPanelSide + kPanelTop + kPanelMargin, Rgb8(255));
  cv::Mat all(image.height(), image.width(), CV_8UC3, image.elements().data());
  cv::Mat stops = all(cv::Rect(kPanelMargin, kPanelTop, kPanelSide, kPanelSide));
  cv::Mat plain = all(cv::Rect(2 * kPanelMargin + kPanelSide, kPanelTop, kPanelSide, kPanelSide));
  const auto write = [&](const std::string& text, cv::Point at, double size = 0.45) {
    cv::putText(all, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kInk, 1, cv::LINE_AA);
  };
  const auto in_stops = [](double v) { return kPanelSide * (1.0 + std::log2(std::max(v, 1e-9)) / kStops); };
  const auto pixel = [](double x, double y) {
    return cv::Point{static_cast<int>(std::lround(std::clamp(x, -1e4, 1e4))),
                     kPanelSide - static_cast<int>(std::lround(std::clamp(y, -1e4, 1e4)))};
  };
  for (int i = 0; i <= 10; ++i) {
    const double at = kPanelSide * i / 10.0;
    for (auto* panel : {&stops, &plain}) {
      cv::line(*panel, pixel(at, 0), pixel(at, kPanelSide), kGrid);
      cv::line(*panel, pixel(0, at), pixel(kPanelSide, at), kGrid);
    }
    if (i % 2 != 0) continue;
    write(fmt::format("{}", i - 10), {kPanelMargin + static_cast<int>(at) - 10, kPanelTop + kPanelSide + 18}, 0.4);
    write(fmt::format("{}", i - 10), {kPanelMargin - 30, kPanelTop + kPanelSide - static_cast<int>(at) + 5}, 0.4);
    write(fmt::format("{:.1f}", i / 10.0),
          {2 * kPanelMargin + kPanelSide + static_cast<int>(at) - 10, kPanelTop + kPanelSide + 18}, 0.4);
    write(fmt::format("{:.1f}", i / 10.0),
          {2 * kPanelMargin + kPanelSide - 30, kPanelTop + kPanelSide - static_cast<int>(at) + 5}, 0.4);
  }
  for (int c = 0; c < 3; ++c) {
    const auto& dot = kChannelDots[static_cast<std::size_t>(c)];
    for (std::size_t i = 0; i < samples.pixels; i += std::max<std::size_t>(1, samples.pixels / 1500)) {
      const double light = light_of(samples, fit, c, i);
      for (std::size_t j = 0; j < samples.exposures && light > 0.0; ++j) {
        const double value = samples.at(c, i, j), here = light * std::exp(fit.log_s[j]);
        if (value < samples.quantum || value >= kSaturated) continue;
        cv::circle(stops, pixel(in_stops(here), in_stops(value)), 1, dot, -1);
        cv::circle(plain, pixel(kPanelSide * here, kPanelSide * value), 1, dot, -1);
      }
    }
  }
  for (int c = 0; c < 3; ++c) {
    const auto& curve = fit.light[static_cast<std::size_t>(c)];
    for (std::size_t k = 1; k + 1 < curve.size(); ++k) {
      const double a = static_cast<double>(k) / static_cast<double>(curve.size() - 1);
      const double b = static_cast<double>(k + 1) / static_cast<double>(curve.size() - 1);
      const auto& ink = kChannelInk[static_cast<std::size_t>(c)];
      cv::line(stops, pixel(in_stops(curve[k]), in_stops(a)), pixel(in_stops(curve[k + 1]), in_stops(b)), ink, 1,
               cv::LINE_AA);
      cv::line(plain, pixel(kPanelSide * curve[k], kPanelSide * a), pixel(kPanelSide * curve[k + 1], kPanelSide * b),
               ink, 1, cv::LINE_AA);
    }
  }
  for (auto* panel : {&stops, &plain}) cv::rectangle(*panel, cv::Rect(0, 0, kPanelSide, kPanelSide), kInk);
  write(title, {kPanelMargin, 35}, 0.55);
  write("value over light, stops below full scale; dots: pixels of the stack",
        {kPanelMargin, kPanelTop + kPanelSide + 42});
  write("the same, linear", {2 * kPanelMargin + kPanelSide, kPanelTop + kPanelSide + 42});
  return image;
}

}  // namespace kasumi
