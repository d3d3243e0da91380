#include "tests/paper/similarity.hpp"

#include <opencv2/imgproc.hpp>

namespace kasumi::paper {
namespace {

cv::Mat matrix_of(const Image<Rgb8>& picture) {
  cv::Mat matrix(picture.height(), picture.width(), CV_8UC3);
  for (int y = 0; y < picture.height(); ++y)
    for (int x = 0; x < picture.width(); ++x) {
      const auto& pixel = picture.at(x, y);
      matrix.at<cv::Vec3b>(y, x) = {pixel.r, pixel.g, pixel.b};
    }
  return matrix;
}

cv::Mat luma_of(const Image<Rgb8>& picture) {
  cv::Mat colour, luma;
  matrix_of(picture).convertTo(colour, CV_32FC3);
  cv::cvtColor(colour, luma, cv::COLOR_RGB2GRAY);
  luma.convertTo(luma, CV_64F);
  return luma;
}

constexpr int kWindow = 11;
// Weighted mean around every pixel whose window lies inside the picture.
cv::Mat mean_of(const cv::Mat& values) {
  cv::Mat blurred;
  cv::GaussianBlur(values, blurred, {kWindow, kWindow}, 1.5, 1.5);
  constexpr int kEdge = kWindow / 2;
  return blurred(cv::Rect(kEdge, kEdge, values.cols - 2 * kEdge, values.rows - 2 * kEdge));
}

double correlation(const cv::Mat& one, const cv::Mat& other, int channel, int bins, float end) {
  const float range[] = {0.0F, end};
  const float* ranges[] = {range};
  cv::Mat histogram_one, histogram_other;
  cv::calcHist(&one, 1, &channel, {}, histogram_one, 1, &bins, ranges);
  cv::calcHist(&other, 1, &channel, {}, histogram_other, 1, &bins, ranges);
  return cv::compareHist(histogram_one, histogram_other, cv::HISTCMP_CORREL);
}

}  // namespace

double ssim(const Image<Rgb8>& one, const Image<Rgb8>& other) {
  constexpr double kC1 = 0.01 * 255 * 0.01 * 255, kC2 = 0.03 * 255 * 0.03 * 255;
  const cv::Mat a = luma_of(one), b = luma_of(other);
  const cv::Mat mean_a = mean_of(a), mean_b = mean_of(b);
  const cv::Mat both = mean_a.mul(mean_b), squares = mean_a.mul(mean_a) + mean_b.mul(mean_b);
  const cv::Mat variances = mean_of(a.mul(a)) + mean_of(b.mul(b)) - squares;
  const cv::Mat covariance = mean_of(a.mul(b)) - both;
  const cv::Mat above = (2.0 * both + kC1).mul(2.0 * covariance + kC2);
  const cv::Mat below = (squares + kC1).mul(variances + kC2);
  return cv::mean(above / below)[0];
}

HsvCorrelation hsv_correlation(const Image<Rgb8>& one, const Image<Rgb8>& other) {
  cv::Mat a, b;
  cv::cvtColor(matrix_of(one), a, cv::COLOR_RGB2HSV);
  cv::cvtColor(matrix_of(other), b, cv::COLOR_RGB2HSV);
  return {correlation(a, b, 0, 30, 180.0F), correlation(a, b, 1, 32, 256.0F), correlation(a, b, 2, 32, 256.0F)};
}

}  // namespace kasumi::paper
