// Where something sways in a series of pictures.
#pragma once

#include <opencv2/core.hpp>

#include "calib/mask/picture_series.hpp"

namespace kasumi {

// Within `box`, and what that encloses: 255.
cv::Mat1b swaying(const PictureSeries& series, const cv::Rect& box);

// Keeps the connected parts of at least `least` pixels.
void keep_large(cv::Mat1b& of, double least);

// For morphology: all pixels up to `radius_px` away.
cv::Mat disc_of(int radius_px);

}  // namespace kasumi
