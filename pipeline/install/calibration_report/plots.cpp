#include "pipeline/install/calibration_report/plots.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "pipeline/install/calibration_report/histogram.hpp"
#include "pipeline/install/calibration_report/plot_style.hpp"

namespace kasumi {

namespace {

constexpr int kFitMargin = 50;
constexpr double kMagnified = 50.0;
const cv::Scalar kUnseenCell(215, 215, 215);

struct Canvas {
  Image<Rgb8> image{2 * kPanelSide + 3 * kFitMargin, kPanelSide + kPanelTop + kFitMargin, Rgb8(255)};
  cv::Mat all{image.height(), image.width(), CV_8UC3, image.elements().data()};
  cv::Mat left = all(cv::Rect(kFitMargin, kPanelTop, kPanelSide, kPanelSide));
  cv::Mat right = all(cv::Rect(2 * kFitMargin + kPanelSide, kPanelTop, kPanelSide, kPanelSide));

  void write(const std::string& text, cv::Point at, double size = 0.45) {
    cv::putText(all, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kInk, 1, cv::LINE_AA);
  }
};

cv::Point at_pixel(const glm::dvec2& pixel, double scale) {
  return {static_cast<int>(std::lround((pixel.x + 0.5) * scale)),
          static_cast<int>(std::lround((pixel.y + 0.5) * scale))};
}

void draw_residual(cv::Mat& panel, const glm::dvec2& pixel, const glm::dvec2& residual, double scale,
                   const cv::Scalar& colour) {
  const auto from = at_pixel(pixel, scale), to = at_pixel(pixel + kMagnified * residual, scale);
  cv::line(panel, from, to, colour, 1, cv::LINE_AA);
  cv::circle(panel, from, 2, colour, -1, cv::LINE_AA);
}

void paste_histogram(Canvas& canvas, const std::vector<double>& lengths_px, const std::string& of_what) {
  auto histogram = plot_histogram(lengths_px, kPanelSide + 2 * kAxisHeight, kPanelSide + kAxisHeight,
                                  fmt::format("distance in pixels of {} {}", lengths_px.size(), of_what));
  const cv::Mat drawn(histogram.height(), histogram.width(), CV_8UC3, histogram.elements().data());
  drawn.copyTo(canvas.all(cv::Rect(2 * kFitMargin + kPanelSide - kAxisHeight, kPanelTop, drawn.cols, drawn.rows)));
}

}  // namespace

Image<Rgb8> plot_lens(const LensCalibration& calibration, int width, int height, const std::string& title) {
  Canvas canvas;
  const double scale = static_cast<double>(kPanelSide) / std::max(width, height);
  constexpr int kCells = BoardCoverage::kCells;
  for (int y = 0; y < kCells; ++y)
    for (int x = 0; x < kCells; ++x)
      if (calibration.coverage.corners[static_cast<std::size_t>(y * kCells + x)] == 0)
        cv::rectangle(
            canvas.left,
            cv::Point(static_cast<int>(scale * width * x / kCells), static_cast<int>(scale * height * y / kCells)),
            cv::Point(static_cast<int>(scale * width * (x + 1) / kCells),
                      static_cast<int>(scale * height * (y + 1) / kCells)),
            kUnseenCell, -1);
  std::vector<double> lengths;
  for (std::size_t v = 0; v < calibration.views.size(); ++v)
    for (std::size_t i = 0; i < calibration.views[v].pixels.size(); ++i) {
      const auto& residual = calibration.fit.views[v].residuals_px[i];
      draw_residual(canvas.left, calibration.views[v].pixels[i], residual, scale, kGood);
      lengths.push_back(glm::length(residual));
    }
  cv::rectangle(canvas.left,
                cv::Rect(0, 0, static_cast<int>(scale * width), static_cast<int>(scale * height)) &
                    cv::Rect(0, 0, kPanelSide, kPanelSide),
                kInk);
  cv::drawMarker(canvas.left, at_pixel(centre_of(calibration.fit.lens), scale), kBad, cv::MARKER_CROSS, 14, 1,
                 cv::LINE_AA);
  canvas.write(title, {kFitMargin, 35}, 0.55);
  canvas.write("corners, residuals x 50; grey: no corner was seen; red: the lens's centre",
               {kFitMargin, kPanelTop + kPanelSide + 25});
  paste_histogram(canvas, lengths, "corners");
  return canvas.image;
}

Image<Rgb8> plot_sun_track(const Image<Rgb8>& picture, std::span<const SunSight> sights,
                           const OrientationFit& orientation, const std::string& title) {
  Canvas canvas;
  const double scale = static_cast<double>(kPanelSide) / std::max(picture.width(), picture.height());
  for (int y = 0; y < kPanelSide; ++y)
    for (int x = 0; x < kPanelSide; ++x) {
      const int px = static_cast<int>(x / scale), py = static_cast<int>(y / scale);
      if (!picture.contains(px, py)) continue;
      const auto& p = picture.at(px, py);
      canvas.left.at<cv::Vec3b>(y, x) = {p.r, p.g, p.b};
    }
  const auto lens = make_lens(orientation.lens);
  std::vector<double> lengths;
  std::optional<cv::Point> before;
  for (const auto& sight : sights) {
    const auto modelled = lens->project(sight.sun * orientation.to_world);
    if (!modelled) {
      before.reset();
      continue;
    }
    const auto here = at_pixel(*modelled, scale);
    if (before) cv::line(canvas.left, *before, here, cv::Scalar(40, 90, 220), 1, cv::LINE_AA);
    before = here;
  }
  for (std::size_t i = 0; i < sights.size(); ++i) {
    if (!orientation.used[i]) {
      cv::circle(canvas.left, at_pixel(sights[i].pixel, scale), 4, kBad, 1, cv::LINE_AA);
      continue;
    }
    draw_residual(canvas.left, sights[i].pixel, orientation.residuals_px[i], scale, kGood);
    lengths.push_back(glm::length(orientation.residuals_px[i]));
  }
  canvas.write(title, {kFitMargin, 35}, 0.55);
  canvas.write("green: the sun, residuals x 50; red: rejected; blue: the fitted path",
               {kFitMargin, kPanelTop + kPanelSide + 25});
  paste_histogram(canvas, lengths, "places of the sun");
  return canvas.image;
}

}  // namespace kasumi
