// The sun's glow: white without being cloud.
#pragma once

#include <optional>

#include "estimator/cloud_cover/pixel_features.hpp"

namespace kasumi {

// Where the largest white patch is thickest: the sun, its bloom, or a bright cloud before it. Empty without one.
std::optional<SunDirection> brightest_patch(const PixelFeatures& sky, const cv::Mat1b& region);

// 255 where white sky (`white`, or clipped) is the sun's or the horizon's glow: it is smooth, as no cloud is, and is
// connected to the sun without a cloud's edge in between or lies just above the horizon.
cv::Mat1b glow(const PixelFeatures& sky, const cv::Mat1b& region, const cv::Mat1b& white, const cv::Mat1f& sun_deg);

}  // namespace kasumi
