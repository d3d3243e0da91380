// The even area around the image circle.
#pragma once

#include <opencv2/core.hpp>

namespace kasumi {

// 255 where tones continue from a corner of the frame without a step and stay near the corner's, of any colour;
// 0 elsewhere. `reach` is how far tones may stray.
cv::Mat1b surround_of(const cv::Mat3f& tones, double reach);

}  // namespace kasumi
