#include "pipeline/calibration_report/plots.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace kasumi {

namespace {

constexpr int kSide = 560, kMargin = 60, kTop = 60;
const cv::Scalar kInk(40, 40, 40), kFaint(225, 225, 225), kGood(40, 150, 60), kBad(220, 50, 40);
const std::array kChannels{cv::Scalar(200, 40, 40), cv::Scalar(40, 150, 60), cv::Scalar(40, 80, 210)};
const std::array kPale{cv::Scalar(240, 190, 190), cv::Scalar(180, 225, 188), cv::Scalar(185, 200, 240)};

void draw_channel(cv::Mat& panel, const SpectralSensitivity& sensitivity, int channel, const cv::Scalar& colour,
                  int thick) {
  double largest = 1e-9;
  for (const auto& sample : sensitivity.samples) largest = std::max(largest, sample[channel]);
  cv::Point before;
  for (int x = 0; x <= kSide; x += 4) {
    const double nm = kFirstVisible_nm + (kLastVisible_nm - kFirstVisible_nm) * x / kSide;
    const double tall = 0.95 * kSide * sensitivity.at(nm)[channel] / largest;
    const cv::Point here{x, kSide - static_cast<int>(std::lround(tall))};
    if (x > 0) cv::line(panel, before, here, colour, thick, cv::LINE_AA);
    before = here;
  }
}

}  // namespace

Image<Rgb8> plot_colour(const SpectralSensitivity& taken, std::span<const SpectralSensitivity> cameras,
                        const ColourResiduals& residuals, const std::string& title) {
  Image<Rgb8> image(2 * kSide + 3 * kMargin, kSide + kTop + kMargin, Rgb8(255));
  cv::Mat all(image.height(), image.width(), CV_8UC3, image.elements().data());
  cv::Mat curves = all(cv::Rect(kMargin, kTop, kSide, kSide));
  cv::Mat left = all(cv::Rect(2 * kMargin + kSide, kTop, kSide, kSide));
  const auto write = [&](const std::string& text, cv::Point at, double size = 0.45) {
    cv::putText(all, text, at, cv::FONT_HERSHEY_SIMPLEX, size, kInk, 1, cv::LINE_AA);
  };
  const double reach = std::max(0.002, 5.0 * residuals.rms);
  for (int i = 0; i <= 8; ++i) {
    const int at = kSide * i / 8;
    for (auto* panel : {&curves, &left}) cv::line(*panel, {at, 0}, {at, kSide}, kFaint);
    cv::line(left, {0, at}, {kSide, at}, kFaint);
    write(fmt::format("{}", 380 + 50 * i), {kMargin + at - 12, kTop + kSide + 18}, 0.4);
    if (i % 2 != 0) continue;
    const double percent = 100.0 * reach * (i - 4) / 4.0;
    write(fmt::format("{:+.2f}", percent), {2 * kMargin + kSide + at - 18, kTop + kSide + 18}, 0.4);
    write(fmt::format("{:+.2f}", percent), {kMargin + kSide + 10, kTop + kSide - at + 5}, 0.4);
  }
  for (const auto& camera : cameras)
    for (int c = 0; c < 3; ++c) draw_channel(curves, camera, c, kPale[static_cast<std::size_t>(c)], 1);
  for (int c = 0; c < 3; ++c) draw_channel(curves, taken, c, kChannels[static_cast<std::size_t>(c)], 2);
  for (const bool used : {false, true})
    for (std::size_t i = 0; i < residuals.left.size(); ++i) {
      if (residuals.used[i] != used) continue;
      const auto place = [&](double v) {
        return static_cast<int>(std::lround(kSide * (0.5 + 0.5 * std::clamp(v / reach, -1.0, 1.0))));
      };
      cv::circle(left, {place(residuals.left[i].x), kSide - place(residuals.left[i].y)}, 2, used ? kGood : kBad, -1,
                 cv::LINE_AA);
    }
  for (auto* panel : {&curves, &left}) cv::rectangle(*panel, cv::Rect(0, 0, kSide, kSide), kInk);
  write(title, {kMargin, 35}, 0.55);
  write("sensitivity over wavelength in nm; pale: the measured cameras", {kMargin, kTop + kSide + 42});
  write("what is left of ln R/G (across) and ln B/G (up), in %; red: left aside",
        {2 * kMargin + kSide, kTop + kSide + 42});
  return image;
}

}  // namespace kasumi
