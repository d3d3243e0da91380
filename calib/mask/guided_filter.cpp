#include "calib/mask/guided_filter.hpp"

#include <algorithm>
#include <array>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <opencv2/imgproc.hpp>

namespace kasumi {
namespace {

// Mean over the part of each window that lies in the picture.
class WindowMean {
 public:
  WindowMean(cv::Size size, int radius_px) : side_(2 * radius_px + 1) { count_ = sum_of(cv::Mat::ones(size, CV_64F)); }
  cv::Mat operator()(const cv::Mat& values) const { return sum_of(values) / count_; }

 private:
  cv::Mat sum_of(const cv::Mat& values) const {
    cv::Mat sum;
    cv::boxFilter(values, sum, CV_64F, {side_, side_}, {-1, -1}, false, cv::BORDER_CONSTANT);
    return sum;
  }
  int side_;
  cv::Mat count_;
};

}  // namespace

Image<float> guided_filter(const Image<glm::vec3>& guide, const Image<float>& input, int radius_px, double epsilon,
                           int step) {
  const cv::Size whole(guide.width(), guide.height());
  cv::Mat p(whole, CV_64F);
  std::array<cv::Mat, 3> channel;
  for (auto& plane : channel) plane.create(whole, CV_64F);
  for (int y = 0; y < whole.height; ++y)
    for (int x = 0; x < whole.width; ++x) {
      p.at<double>(y, x) = static_cast<double>(input.at(x, y));
      for (int c = 0; c < 3; ++c)
        channel[static_cast<std::size_t>(c)].at<double>(y, x) = static_cast<double>(guide.at(x, y)[c]);
    }
  const auto full_size = channel;
  if (step > 1) {
    const cv::Size smaller(std::max(1, whole.width / step), std::max(1, whole.height / step));
    for (auto& plane : channel) {
      cv::Mat shrunk;
      cv::resize(plane, shrunk, smaller, 0.0, 0.0, cv::INTER_AREA);
      plane = shrunk;
    }
    cv::Mat shrunk;
    cv::resize(p, shrunk, smaller, 0.0, 0.0, cv::INTER_AREA);
    p = shrunk;
    radius_px = std::max(1, radius_px / step);
  }
  const int width = p.cols, height = p.rows;
  const WindowMean mean({width, height}, radius_px);
  const cv::Mat mean_p = mean(p);
  std::array<cv::Mat, 3> mean_i, with_p, slope;
  std::array<std::array<cv::Mat, 3>, 3> with;
  for (std::size_t i = 0; i < 3; ++i) {
    mean_i[i] = mean(channel[i]);
    slope[i].create(height, width, CV_64F);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    with_p[i] = mean(channel[i].mul(p)) - mean_i[i].mul(mean_p);
    for (std::size_t j = i; j < 3; ++j)
      with[i][j] = with[j][i] = mean(channel[i].mul(channel[j])) - mean_i[i].mul(mean_i[j]);
  }
  cv::Mat offset(height, width, CV_64F);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      glm::dmat3 covariance{0.0};
      glm::dvec3 cross{0.0}, means{0.0};
      for (std::size_t i = 0; i < 3; ++i) {
        const int row = static_cast<int>(i);
        cross[row] = with_p[i].at<double>(y, x);
        means[row] = mean_i[i].at<double>(y, x);
        for (std::size_t j = 0; j < 3; ++j) covariance[static_cast<int>(j)][row] = with[i][j].at<double>(y, x);
      }
      const auto a = glm::inverse(covariance + glm::dmat3(epsilon)) * cross;
      for (std::size_t i = 0; i < 3; ++i) slope[i].at<double>(y, x) = a[static_cast<int>(i)];
      offset.at<double>(y, x) = mean_p.at<double>(y, x) - glm::dot(a, means);
    }
  const auto enlarged = [&](cv::Mat smooth) {
    if (step > 1) cv::resize(smooth, smooth, whole, 0.0, 0.0, cv::INTER_LINEAR);
    return smooth;
  };
  cv::Mat result = enlarged(mean(offset));
  for (std::size_t i = 0; i < 3; ++i) result += enlarged(mean(slope[i])).mul(full_size[i]);
  Image<float> filtered(whole.width, whole.height);
  for (int y = 0; y < whole.height; ++y)
    for (int x = 0; x < whole.width; ++x) filtered.at(x, y) = static_cast<float>(result.at<double>(y, x));
  return filtered;
}

}  // namespace kasumi
