#include "pipeline/install/calibration_report/plots.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "pipeline/install/calibration_report/plot_style.hpp"

namespace kasumi {

namespace {

const std::array kPaleChannels{cv::Scalar(240, 190, 190), cv::Scalar(180, 225, 188), cv::Scalar(185, 200, 240)};

void draw_channel(cv::Mat& panel, const SpectralSensitivity& sensitivity, int channel, const cv::Scalar& colour,
                  int thick) {
  double largest = 1e-9;
  for (const auto& sample : sensitivity.samples) largest = std::max(largest, sample[channel]);
  cv::Point before;
  for (int x = 0; x <= kPanelSide; x += 4) {
    const double nm = kFirstVisible_nm + (kLastVisible_nm - kFirstVisible_nm) * x / kPanelSide;
    const double tall = 0.95 * kPanelSide * sensitivity.at(nm)[channel] / largest;
    const cv::Point here{x, kPanelSide - static_cast<int>(std::lround(tall))};
    if (x > 0) cv::line(panel, before, here, colour, thick, cv::LINE_AA);
    before = here;
  }
}

}  // namespace

Image<Rgb8> plot_colour(const SpectralSensitivity& taken, std::span<const SpectralSensitivity> cameras,
                        const ColourResiduals& residuals, const std::string& title) {
  Image<Rgb8> image(2 * kPanelSide + 3 * kPanelMargin, kPanelSide + kPanelTop + kPanelMargin, Rgb8(255));
  cv::Mat all(image.height(), image.width(), CV_8UC3, image.elements().data());
  cv::Mat curves = all(cv::Rect(kPanelMargin, kPanelTop, kPanelSide, kPanelSide));
  cv::Mat left = all(cv::Rect(2 * kPanelMargin + kPanelSide, kPanelTop, kPanelSide, kPanelSide));
  const auto write = [&](const std::string& text, cv::Point at, double size = 0.45) {
    cv::putText(all, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kInk, 1, cv::LINE_AA);
  };
  const double reach = std::max(0.002, 5.0 * residuals.rms);
  for (int i = 0; i <= 8; ++i) {
    const int at = kPanelSide * i / 8;
    for (auto* panel : {&curves, &left}) cv::line(*panel, {at, 0}, {at, kPanelSide}, kGrid);
    cv::line(left, {0, at}, {kPanelSide, at}, kGrid);
    write(fmt::format("{}", 380 + 50 * i), {kPanelMargin + at - 12, kPanelTop + kPanelSide + 18}, 0.4);
    if (i % 2 != 0) continue;
    const double percent = 100.0 * reach * (i - 4) / 4.0;
    write(fmt::format("{:+.2f}", percent), {2 * kPanelMargin + kPanelSide + at - 18, kPanelTop + kPanelSide + 18}, 0.4);
    write(fmt::format("{:+.2f}", percent), {kPanelMargin + kPanelSide + 10, kPanelTop + kPanelSide - at + 5}, 0.4);
  }
  for (const auto& camera : cameras)
    for (int c = 0; c < 3; ++c) draw_channel(curves, camera, c, kPaleChannels[static_cast<std::size_t>(c)], 1);
  for (int c = 0; c < 3; ++c) draw_channel(curves, taken, c, kChannelInk[static_cast<std::size_t>(c)], 2);
  for (const bool used : {false, true})
    for (std::size_t i = 0; i < residuals.left.size(); ++i) {
      if (residuals.used[i] != used) continue;
      const auto place = [&](double v) {
        return static_cast<int>(std::lround(kPanelSide * (0.5 + 0.5 * std::clamp(v / reach, -1.0, 1.0))));
      };
      cv::circle(left, {place(residuals.left[i].x), kPanelSide - place(residuals.left[i].y)}, 2, used ? kGood : kBad,
                 -1, cv::LINE_AA);
    }
  for (auto* panel : {&curves, &left}) cv::rectangle(*panel, cv::Rect(0, 0, kPanelSide, kPanelSide), kInk);
  write(title, {kPanelMargin, 35}, 0.55);
  write("sensitivity over wavelength in nm; pale: the measured cameras", {kPanelMargin, kPanelTop + kPanelSide + 42});
  write("residuals of ln R/G (across) and ln B/G (up), in %; red: rejected",
        {2 * kPanelMargin + kPanelSide, kPanelTop + kPanelSide + 42});
  return image;
}

}  // namespace kasumi
