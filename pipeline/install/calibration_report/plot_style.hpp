// Colours and measures that the plots of a calibration share.
#pragma once

#include <array>

#include <opencv2/core.hpp>

namespace kasumi {

inline constexpr int kPanelSide = 560, kPanelMargin = 60, kPanelTop = 60, kAxisHeight = 40;
inline const cv::Scalar kInk(40, 40, 40), kGrid(225, 225, 225), kGood(40, 150, 60), kBad(220, 50, 40);
inline const std::array kChannelInk{cv::Scalar(200, 40, 40), kGood, cv::Scalar(40, 80, 210)};

}  // namespace kasumi
