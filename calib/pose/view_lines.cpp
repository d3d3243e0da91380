#include "calib/pose/view_lines.hpp"

#include <cmath>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace kasumi {
namespace {

constexpr int kWindow_px = 25;                // over which the picture is relative to its mean and contrast
constexpr double kMinPatternContrast = 0.02;  // of the mean: less is noise
constexpr int kRim_px = 3;                    // the picture ends there, and its end does not move
constexpr double kSoftness_px = 1.0;
constexpr float kUnit = 0.03f;  // steepness of one step of strength, in contrasts per element
constexpr float kFaint = 1.5f;  // less is the noise of even parts

cv::Mat mat_over(const Image<float>& image) {
  return cv::Mat(image.height(), image.width(), CV_32F, const_cast<float*>(image.elements().data()));
}

// Relative to mean and contrast around, of what is seen. In linear light an edge stays where it is when its contrast
// changes; in its logarithm it would move.
cv::Mat pattern_of(const cv::Mat& light, const cv::Mat& seen) {
  const cv::Size window{kWindow_px, kWindow_px};
  cv::Mat share, mean, square;
  cv::blur(seen, share, window);
  share += 1e-6f;
  cv::blur(light.mul(seen), mean, window);
  mean /= share;
  const cv::Mat deviation = (light - mean).mul(seen);
  cv::blur(deviation.mul(deviation), square, window);
  cv::sqrt(square / share + kMinPatternContrast * kMinPatternContrast * mean.mul(mean) + 1e-12, square);
  return deviation / square;
}

}  // namespace

Image<float> seen_by(const Lens& lens, int width, int height, int factor) {
  Image<float> seen(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) seen.at(x, y) = lens.unproject(unshrunk(x, y, factor)) ? 1.0f : 0.0f;
  auto mat = mat_over(seen);
  cv::erode(mat, mat, {}, {-1, -1}, kRim_px, cv::BORDER_REPLICATE);
  return seen;
}

ViewLines lines_of(const Lens& lens, const ShrunkView& view) {
  ViewLines lines{Image<std::uint8_t>(view.light.width(), view.light.height()), view.factor, view.usable};
  const auto seen = seen_by(lens, view.light.width(), view.light.height(), view.factor);
  cv::Mat soft, across, down, steepness;
  cv::GaussianBlur(pattern_of(mat_over(view.light), mat_over(seen)), soft, {}, kSoftness_px);
  cv::Sobel(soft, across, CV_32F, 1, 0, 3, 0.125);
  cv::Sobel(soft, down, CV_32F, 0, 1, 3, 0.125);
  cv::magnitude(across, down, steepness);
  for (int y = 0; y < steepness.rows; ++y)
    for (int x = 0; x < steepness.cols; ++x) {
      const float strength = steepness.at<float>(y, x) / kUnit;
      if (strength >= kFaint)
        lines.strength.at(x, y) = static_cast<std::uint8_t>(std::lround(std::fmin(strength, ViewLines::kStrongest)));
    }
  return lines;
}

}  // namespace kasumi
