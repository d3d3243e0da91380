// The search for the circle that bounds a fisheye picture.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "calib/mask/rim_evidence.hpp"
#include "calib/mask/rim_fit.hpp"

namespace kasumi {

struct RankedRim {
  Rim rim;
  RimEvidence evidence;
  double score = 0.0;  // ln odds that it is right
};
// All circles with any evidence, the likeliest first.
std::vector<RankedRim> ranked_rims(const cv::Mat3f& tones);

// By the larger of the differences of centre and radius, as a share of b's radius.
double difference(const Rim& a, const Rim& b);

}  // namespace kasumi
