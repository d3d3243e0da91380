#include "pipeline/lab/comparison/similarity.hpp"

#include <opencv2/imgproc.hpp>

namespace kasumi {
namespace {

constexpr int kWindow = 11;
constexpr int kEdge = kWindow / 2;

// R G B in steps of 1 / 255, unrounded.
cv::Mat steps_of(const Image<Rgb8>& picture) {
  cv::Mat steps(picture.height(), picture.width(), CV_32FC3);
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const auto& pixel = picture.at(x, y);
      steps.at<cv::Vec3f>(y, x) = {float(pixel.r), float(pixel.g), float(pixel.b)};
    }
  return steps;
}

cv::Mat steps_of(const Image<glm::vec3>& encoded) {
  cv::Mat steps(encoded.height(), encoded.width(), CV_32FC3);
  for (int y = 0; y < encoded.height(); ++y)
    for (int x = 0; x < encoded.width(); ++x) {
      const glm::vec3 pixel = 255.0F * encoded.at(x, y);
      steps.at<cv::Vec3f>(y, x) = {pixel.r, pixel.g, pixel.b};
    }
  return steps;
}

// 255 where a pixel counts; empty: all do.
cv::Mat matrix_of(const CountedPixels& counted) {
  if (counted.empty()) return {};
  cv::Mat mask(counted.height(), counted.width(), CV_8U);
  for (int y = 0; y < counted.height(); ++y)
    for (int x = 0; x < counted.width(); ++x) mask.at<std::uint8_t>(y, x) = counted.at(x, y) == 0 ? 0 : 255;
  return mask;
}

cv::Rect windows_inside(const cv::Mat& picture) {
  return {kEdge, kEdge, picture.cols - 2 * kEdge, picture.rows - 2 * kEdge};
}

// Weighted mean around every pixel whose window lies inside the picture.
cv::Mat mean_of(const cv::Mat& values) {
  cv::Mat blurred;
  cv::GaussianBlur(values, blurred, {kWindow, kWindow}, 1.5, 1.5);
  return blurred(windows_inside(values));
}

cv::Mat luma_of(const cv::Mat& steps) {
  cv::Mat luma;
  cv::cvtColor(steps, luma, cv::COLOR_RGB2GRAY);
  luma.convertTo(luma, CV_64F);
  return luma;
}

// Of each window that lies inside the picture.
cv::Mat ssim_map(const cv::Mat& steps_one, const cv::Mat& steps_other) {
  constexpr double kC1 = 0.01 * 255 * 0.01 * 255, kC2 = 0.03 * 255 * 0.03 * 255;
  const cv::Mat a = luma_of(steps_one), b = luma_of(steps_other);
  const cv::Mat mean_a = mean_of(a), mean_b = mean_of(b);
  const cv::Mat both = mean_a.mul(mean_b), squares = mean_a.mul(mean_a) + mean_b.mul(mean_b);
  const cv::Mat variances = mean_of(a.mul(a)) + mean_of(b.mul(b)) - squares;
  const cv::Mat covariance = mean_of(a.mul(b)) - both;
  const cv::Mat above = (2.0 * both + kC1).mul(2.0 * covariance + kC2);
  const cv::Mat below = (squares + kC1).mul(variances + kC2);
  return above / below;
}

double correlation(const cv::Mat& one, const cv::Mat& other, const cv::Mat& mask, int channel, int bins, float end) {
  const float range[] = {0.0F, end};
  const float* ranges[] = {range};
  cv::Mat histogram_one, histogram_other;
  cv::calcHist(&one, 1, &channel, mask, histogram_one, 1, &bins, ranges);
  cv::calcHist(&other, 1, &channel, mask, histogram_other, 1, &bins, ranges);
  return cv::compareHist(histogram_one, histogram_other, cv::HISTCMP_CORREL);
}

HsvCorrelation correlation_of(const cv::Mat& steps_one, const cv::Mat& steps_other, const cv::Mat& mask) {
  cv::Mat a, b;
  steps_one.convertTo(a, CV_8UC3);
  steps_other.convertTo(b, CV_8UC3);
  cv::cvtColor(a, a, cv::COLOR_RGB2HSV);
  cv::cvtColor(b, b, cv::COLOR_RGB2HSV);
  return {correlation(a, b, mask, 0, 30, 180.0F), correlation(a, b, mask, 1, 32, 256.0F),
          correlation(a, b, mask, 2, 32, 256.0F)};
}

}  // namespace

double ssim(const Image<Rgb8>& one, const Image<Rgb8>& other) {
  return cv::mean(ssim_map(steps_of(one), steps_of(other)))[0];
}

std::optional<double> ssim(const Image<glm::vec3>& one, const Image<glm::vec3>& other, const CountedPixels& counted) {
  if (one.width() < kWindow || one.height() < kWindow) return std::nullopt;
  const cv::Mat map = ssim_map(steps_of(one), steps_of(other));
  if (counted.empty()) return cv::mean(map)[0];
  cv::Mat whole;
  const cv::Mat mask = matrix_of(counted);
  cv::erode(mask, whole, cv::Mat::ones(kWindow, kWindow, CV_8U));
  const cv::Mat windows = whole(windows_inside(mask));
  if (cv::countNonZero(windows) == 0) return std::nullopt;
  return cv::mean(map, windows)[0];
}

HsvCorrelation hsv_correlation(const Image<Rgb8>& one, const Image<Rgb8>& other) {
  return correlation_of(steps_of(one), steps_of(other), {});
}

HsvCorrelation hsv_correlation(const Image<glm::vec3>& one, const Image<glm::vec3>& other,
                               const CountedPixels& counted) {
  return correlation_of(steps_of(one), steps_of(other), matrix_of(counted));
}

}  // namespace kasumi
