#include "estimator/turbidity/element_maps.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace kasumi {

cv::Mat1f mean_over(const cv::Mat1f& values, const cv::Mat1f& counts, int side) {
  cv::Mat1f sum, number;
  cv::boxFilter(values.mul(counts), sum, CV_32F, {side, side}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::boxFilter(counts, number, CV_32F, {side, side}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::Mat1f mean;
  cv::divide(sum, cv::max(number, 1.0), mean);
  return mean;
}

cv::Mat1f texture_of(const cv::Mat1f& log_luminance, const cv::Mat1f& counts) {
  constexpr int kReach = 2;  // neighbours of second order: texture beyond a single element's noise
  cv::Mat1f uneven(log_luminance.size(), 0.0f), known(log_luminance.size(), 0.0f);
  for (int y = kReach; y + kReach < log_luminance.rows; ++y)
    for (int x = kReach; x + kReach < log_luminance.cols; ++x) {
      if (counts(y, x) * counts(y, x - kReach) * counts(y, x + kReach) * counts(y - kReach, x) *
              counts(y + kReach, x) ==
          0.0f)
        continue;
      const float neighbours = log_luminance(y, x - kReach) + log_luminance(y, x + kReach) +
                               log_luminance(y - kReach, x) + log_luminance(y + kReach, x);
      uneven(y, x) = std::abs(log_luminance(y, x) - 0.25f * neighbours);
      known(y, x) = 1.0f;
    }
  return mean_over(uneven, known, 5);
}

cv::Mat1b grown_over_soft_edges(cv::Mat1b& marked) {
  cv::medianBlur(marked, marked, 3);
  cv::Mat1b grown;
  const int side = 2 * std::max(1, static_cast<int>(std::lround(0.006 * std::min(marked.cols, marked.rows)))) + 1;
  cv::dilate(marked, grown, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
  return grown;
}

}  // namespace kasumi
