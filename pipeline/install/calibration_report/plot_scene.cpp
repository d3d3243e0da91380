#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "pipeline/install/calibration_report/histogram.hpp"
#include "pipeline/install/calibration_report/plot_style.hpp"
#include "pipeline/install/calibration_report/plots.hpp"
#include "pipeline/install/calibration_report/scene_sights.hpp"

namespace kasumi {

namespace {

constexpr int kSceneWidth = 1280, kTitleHeight = 50, kLineHeight = 20, kHistogramHeight = 200;
const cv::Scalar kMarked(255, 210, 0), kUsedMark(60, 220, 90), kLeftOutMark(255, 70, 50), kHorizonLine(80, 160, 255);

// OpenCV's Hershey fonts are ASCII only.
std::string plain(const std::string& text) {
  std::string result;
  for (const char c : text)
    if (const auto code = static_cast<unsigned char>(c); code < 0x80)
      result += c;
    else if (code >= 0xc0)
      result += '?';
  return result;
}

// Seen on bright and dark ground.
void draw_line(cv::Mat& on, cv::Point a, cv::Point b, const cv::Scalar& colour) {
  cv::line(on, a, b, cv::Scalar(0, 0, 0), 3, cv::LINE_AA);
  cv::line(on, a, b, colour, 1, cv::LINE_AA);
}

void write(cv::Mat& on, const std::string& text, cv::Point at, const cv::Scalar& colour, bool outlined) {
  if (outlined) cv::putText(on, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, cv::Scalar(0, 0, 0), 3, cv::LINE_AA);
  cv::putText(on, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv::LINE_AA);
}

}  // namespace

Image<Rgb8> plot_scene(const Image<Rgb8>& picture, std::span<const LandmarkSight> landmarks,
                       std::span<const HorizonSight> horizon, const ScenePose& pose, const std::string& title) {
  const double scale = static_cast<double>(kSceneWidth) / picture.width();
  const int tall = static_cast<int>(std::lround(scale * picture.height()));
  const int lines = static_cast<int>(landmarks.size());
  Image<Rgb8> image(kSceneWidth, kTitleHeight + tall + kLineHeight * (lines + 2) + kHistogramHeight, Rgb8(255));
  cv::Mat all(image.height(), image.width(), CV_8UC3, image.elements().data());
  cv::Mat view = all(cv::Rect(0, kTitleHeight, kSceneWidth, tall));
  auto copy = picture.elements();
  const cv::Mat from(picture.height(), picture.width(), CV_8UC3, copy.data());
  cv::resize(from, view, view.size(), 0, 0, scale < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  const auto at = [&](const glm::dvec2& pixel) {
    const auto limited = [](double v) { return static_cast<int>(std::lround(std::clamp(v, -1e4, 1e4))); };
    return cv::Point{limited((pixel.x + 0.5) * scale - 0.5), limited((pixel.y + 0.5) * scale - 0.5)};
  };

  const auto lens = make_lens(pose.lens);
  if (!horizon.empty()) {
    const auto axis = azimuth_angle(pose.to_world[2]);
    std::optional<cv::Point> before;
    for (double off = -60.0; off <= 60.0; off += 0.05) {
      const auto direction = direction_from(from_degrees(90.0) + horizon.front().dip, axis + from_degrees(off));
      const auto pixel = lens->project(direction * pose.to_world);
      const bool inside = pixel && pixel->x > -50.0 && pixel->x < picture.width() + 50.0;
      if (inside && before) draw_line(view, *before, at(*pixel), kHorizonLine);
      before = inside ? std::optional(at(*pixel)) : std::nullopt;
    }
    for (const auto& sight : horizon)
      cv::drawMarker(view, at(sight.pixel), kHorizonLine, cv::MARKER_CROSS, 9, 1, cv::LINE_AA);
  }
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    const auto& colour = pose.used[i] ? kUsedMark : kLeftOutMark;
    const auto marked = at(landmarks[i].pixel), modelled = at(landmarks[i].pixel - pose.residuals_px[i]);
    draw_line(view, marked, modelled, colour);
    cv::circle(view, modelled, 7, cv::Scalar(0, 0, 0), 3, cv::LINE_AA);
    cv::circle(view, modelled, 7, colour, 1, cv::LINE_AA);
    cv::drawMarker(view, marked, cv::Scalar(0, 0, 0), cv::MARKER_CROSS, 12, 3, cv::LINE_AA);
    cv::drawMarker(view, marked, kMarked, cv::MARKER_CROSS, 11, 1, cv::LINE_AA);
    write(view, fmt::format("{}", i + 1), marked + cv::Point(10, -8), colour, true);
    write(all,
          fmt::format("{:2}  {:<30} {:>11}   {:+7.2f} {:+7.2f} px{}", i + 1, plain(landmarks[i].name),
                      distance_text(landmarks[i]), pose.residuals_px[i].x, pose.residuals_px[i].y,
                      pose.used[i] ? "" : "   left out"),
          {20, kTitleHeight + tall + kLineHeight * (static_cast<int>(i) + 2)}, pose.used[i] ? kInk : kLeftOutMark,
          false);
  }
  std::vector<double> lengths;
  for (std::size_t i = 0; i < landmarks.size(); ++i)
    if (pose.used[i]) lengths.push_back(glm::length(pose.residuals_px[i]));
  const auto of_landmarks = lengths.size();
  for (std::size_t i = 0; i < horizon.size(); ++i)
    if (pose.horizon_used[i]) lengths.push_back(std::abs(pose.horizon_residuals_px[i]));
  auto histogram = plot_histogram(lengths, kSceneWidth / 2, kHistogramHeight,
                                  fmt::format("distance in pixels of {} landmarks and {} points of the horizon",
                                              of_landmarks, lengths.size() - of_landmarks));
  cv::Mat(histogram.height(), histogram.width(), CV_8UC3, histogram.elements().data())
      .copyTo(all(cv::Rect(0, image.height() - kHistogramHeight, kSceneWidth / 2, kHistogramHeight)));
  write(all, title, {20, 20}, kInk, false);
  write(all, "cross: as marked; circle: where its coordinates appear (green: used, red: left out); blue: horizon",
        {20, 40}, kInk, false);
  return image;
}

}  // namespace kasumi
