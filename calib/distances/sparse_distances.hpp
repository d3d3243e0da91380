// Maps of distances with gaps: a lidar's scattered points, the holes of stereo.
#pragma once

#include <string>

#include "base/image.hpp"

namespace kasumi {

// Where most neighbours of the known pixels (finite, > 0) are not known, the gaps between them get the distance of the
// nearest that is, as far as gaps between points go and not above the topmost of the columns around. Says what it did:
// "sparse, 5.1 % of the pixels measured: 52.9 % filled from the nearest"; empty: the map is not sparse, and unchanged.
std::string fill_sparse(Image<float>& metres);

// Regions of zeros smaller than that share of the picture get the distance of the nearest known pixel.
void fill_small_holes(Image<float>& metres, double smallest_sky_share);

}  // namespace kasumi
