// What the plots of a calibration share: measures in pixels, colours.
#pragma once

#include <array>

#include <opencv2/core.hpp>

namespace kasumi {

constexpr int kPlotSide = 560, kPlotMargin = 60, kPlotTop = 60, kPlotAxis = 40;

inline const cv::Scalar kInk(40, 40, 40), kFaint(225, 225, 225), kGood(40, 150, 60), kBad(220, 50, 40);
inline const std::array kChannelInks{cv::Scalar(200, 40, 40), kGood, cv::Scalar(40, 80, 210)};

}  // namespace kasumi
