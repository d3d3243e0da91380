#include "estimator/turbidity/element_maps.hpp"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

namespace kasumi {

MeansOver::MeansOver(const cv::Mat1f& counts, int side) : counts_(counts), side_(side) {
  cv::boxFilter(counts_, number_, CV_32F, {side, side}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::max(number_, 1.0, number_);
}

cv::Mat1f MeansOver::of(const cv::Mat1f& values) const {
  cv::Mat1f mean;
  cv::multiply(values, counts_, mean);
  cv::boxFilter(mean, mean, CV_32F, {side_, side_}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::divide(mean, number_, mean);
  return mean;
}

cv::Mat1f mean_over(const cv::Mat1f& values, const cv::Mat1f& counts, int side) {
  return MeansOver(counts, side).of(values);
}

cv::Mat1f texture_of(const cv::Mat1f& log_luminance, const cv::Mat1f& counts) {
  constexpr int kReach = 2;  // neighbours of second order: texture beyond a single element's noise
  cv::Mat1f uneven(log_luminance.size(), 0.0f), known(log_luminance.size(), 0.0f);
  for (int y = kReach; y + kReach < log_luminance.rows; ++y) {
    const float *above = log_luminance[y - kReach], *here = log_luminance[y], *below = log_luminance[y + kReach];
    const float *count_above = counts[y - kReach], *count = counts[y], *count_below = counts[y + kReach];
    float *uneven_here = uneven[y], *known_here = known[y];
    for (int x = kReach; x + kReach < log_luminance.cols; ++x) {
      const float all = count[x] * count[x - kReach] * count[x + kReach] * count_above[x] * count_below[x];
      const float neighbours = here[x - kReach] + here[x + kReach] + above[x] + below[x];
      uneven_here[x] = all * std::abs(here[x] - 0.25f * neighbours);
      known_here[x] = all;
    }
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
