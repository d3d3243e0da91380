#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "pipeline/install/calibration_report/histogram.hpp"
#include "pipeline/install/calibration_report/plot_style.hpp"
#include "pipeline/install/calibration_report/plots.hpp"

namespace kasumi {

namespace {

const cv::Scalar kCurve(210, 40, 40);

// From blue to orange, one for each picture.
cv::Scalar colour_of(std::size_t i, std::size_t count) {
  const double t = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0.0;
  return {60 + 180 * t, 110 + 30 * t, 220 - 190 * t};
}

}  // namespace

Image<Rgb8> plot_vignetting(const FoundVignetting& found, const std::string& title) {
  Image<Rgb8> image(2 * kPanelSide + 3 * kPanelMargin, kPanelSide + kPanelTop + kPanelMargin, Rgb8(255));
  cv::Mat all(image.height(), image.width(), CV_8UC3, image.elements().data());
  cv::Mat panel = all(cv::Rect(kPanelMargin, kPanelTop, kPanelSide, kPanelSide));
  const auto write = [&](const std::string& text, cv::Point at, double size = 0.45) {
    cv::putText(all, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kInk, 1, cv::LINE_AA);
  };
  const auto& v = found.vignetting;
  // From a little below the darkest to a little above 1.
  double lowest = v.at(v.centre + glm::dvec2{v.radius_px, 0.0}), highest = 1.0;
  for (const auto& moment : found.moments)
    for (const auto& at : moment.profile) {
      lowest = std::min(lowest, at.y);
      highest = std::max(highest, at.y);
    }
  lowest = std::max(0.0, std::floor(20.0 * lowest - 0.4) / 20.0);
  highest = std::ceil(20.0 * highest + 0.4) / 20.0;
  const auto place = [&](double radius_px, double light) {
    return cv::Point{static_cast<int>(std::lround(kPanelSide * radius_px / (1.05 * v.radius_px))),
                     static_cast<int>(std::lround(kPanelSide * (highest - light) / (highest - lowest)))};
  };
  const double step = highest - lowest > 0.4 ? 0.1 : 0.05;
  for (double light = std::ceil(lowest / step) * step; light <= highest; light += step) {
    cv::line(panel, place(0.0, light), {kPanelSide, place(0.0, light).y}, kGrid);
    write(fmt::format("{:.2f}", light), {kPanelMargin - 42, kPanelTop + place(0.0, light).y + 5}, 0.4);
  }
  for (int i = 0; i <= 4; ++i)
    write(fmt::format("{:.0f}", 1.05 * v.radius_px * i / 4.0),
          {kPanelMargin + i * kPanelSide / 4 - 10, kPanelTop + kPanelSide + 17}, 0.4);
  for (std::size_t m = 0; m < found.moments.size(); ++m)
    for (const auto& at : found.moments[m].profile)
      cv::circle(panel, place(at.x, at.y), 3, colour_of(m, found.moments.size()), -1, cv::LINE_AA);
  for (int i = 0; i < 100; ++i) {
    const double a = v.radius_px * i / 100.0, b = v.radius_px * (i + 1) / 100.0;
    cv::line(panel, place(a, v.at(v.centre + glm::dvec2{a, 0.0})), place(b, v.at(v.centre + glm::dvec2{b, 0.0})),
             kCurve, 2, cv::LINE_AA);
  }
  cv::rectangle(panel, cv::Rect(0, 0, kPanelSide, kPanelSide), kInk);
  std::vector<double> percents;
  for (const double residual : found.residuals) percents.push_back(100.0 * std::abs(residual));
  auto histogram = plot_histogram(percents, kPanelSide + 2 * kAxisHeight, kPanelSide + kAxisHeight,
                                  fmt::format("residual in percent of {} places in the sky", percents.size()));
  cv::Mat(histogram.height(), histogram.width(), CV_8UC3, histogram.elements().data())
      .copyTo(all(cv::Rect(2 * kPanelMargin + kPanelSide - kAxisHeight, kPanelTop, kPanelSide + 2 * kAxisHeight,
                           kPanelSide + kAxisHeight)));
  write(title, {kPanelMargin, 35}, 0.55);
  write("illumination over pixels from the centre; dots: the pictures, blue to orange",
        {kPanelMargin, kPanelTop + kPanelSide + 38}, 0.4);
  return image;
}

}  // namespace kasumi
