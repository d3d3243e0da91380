// Circles that a picture's edges suggest.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "calib/mask/rim_edges.hpp"
#include "calib/mask/rim_fit.hpp"

namespace kasumi {

// Rough ones, the best first: where the lines along the edges' normals meet, at the radii at which most of the turn has an edge.
std::vector<Rim> rims_by_votes(const std::vector<RimEdge>& edges, cv::Size frame);

// The circles which most of the border of the surround lies on; of a circle that reaches out of the frame on all sides
// it is what is left.
std::vector<Rim> rims_by_surround(const cv::Mat1b& surround);

}  // namespace kasumi
