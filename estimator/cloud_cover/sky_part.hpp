// Which part of the circle shows sky: walls, trees and hills reach in from the rim.
#pragma once

#include "estimator/cloud_cover/pixel_features.hpp"

namespace kasumi {

// 255 where something stands before the sky. Clouds' edges are soft and broken, walls' are sharp and closed: what sharp
// edges cut off from the largest bright area, touches the rim, and is darker than the sky beside it or of no sky's
// colour stands before the sky; so does what is dark, green or brown and touches the rim.
cv::Mat1b not_sky(const PixelFeatures& sky);

}  // namespace kasumi
