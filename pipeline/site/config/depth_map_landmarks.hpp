// Landmarks that the scene's distance map gives by itself.
#pragma once

#include <string>
#include <vector>

#include "pipeline/site/config/landmarks.hpp"

namespace kasumi {

// What the distance map knows of some pixels.
struct MappedDistance {
  bool known = false;                        // of more than half of them
  double distance_m = 0.0;                   // median
  double nearest_m = 0.0, farthest_m = 0.0;  // without a tenth at either end
  bool even() const { return farthest_m - nearest_m <= 0.25 * distance_m; }
};
MappedDistance mapped_distance(const LandmarkContext& scene, const LandmarkBox& box,
                               const std::optional<RidgeStrip>& ridge);
// Of a surface so far away in the middle of a box; 0 without a camera.
double rise_of(const LandmarkContext& scene, const LandmarkBox& box, double distance_m);

// At most `count`: of as many equal steps of the logarithm of distance, from 300 m to 50 km as far as the map reaches,
// the box in each that lies at one distance (within 8 %) and nearest to the horizon. What they are made of the map does
// not say: their contrast is taken as .75 +- .2 until pictures have taught it.
std::vector<ContrastLandmark> landmarks_in(const LandmarkContext& scene, const std::string& name, int count);

}  // namespace kasumi
