// Quantities of a sky picture's elements, smoothed and grown: where clouds are looked for.
#pragma once

#include <opencv2/core.hpp>

namespace kasumi {

// Means over a square window of the elements that count (1, else 0); zero where there are none.
class MeansOver {
 public:
  MeansOver(const cv::Mat1f& counts, int side);
  cv::Mat1f of(const cv::Mat1f& values) const;

 private:
  cv::Mat1f counts_, number_;
  int side_;
};
cv::Mat1f mean_over(const cv::Mat1f& values, const cv::Mat1f& counts, int side);

// Texture: how far ln Y is from the mean of its neighbours, averaged over a patch. Smooth gradients cancel.
cv::Mat1f texture_of(const cv::Mat1f& log_luminance, const cv::Mat1f& counts);

// Removes single marked elements (noise); returns the rest with a margin: clouds' edges are soft over a degree or two.
cv::Mat1b grown_over_soft_edges(cv::Mat1b& marked);

}  // namespace kasumi
