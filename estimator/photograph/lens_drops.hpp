// Whether drops, breath or dirt lie on a camera's lens, by what its other pictures show.
#pragma once

#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "base/image.hpp"

namespace kasumi {

// How fine the picture's detail is, part by part: light's change from pixel to pixel over its change from eight pixels
// to eight. Fog takes both alike, a drop takes the fine one. NaN: a part without any detail.
struct DetailFineness {
  Image<float> parts;
};
DetailFineness fineness_of(const Image<glm::vec3>& encoded);

// For each picture the share of its parts whose detail is less than two thirds as fine as the median of all pictures.
// Pictures of one size and view; with fewer than five nothing is usual, and all are 0.
std::vector<double> blurred_shares(std::span<const DetailFineness> pictures);

constexpr double kDropsOnLens = 0.3;  // from that share on

}  // namespace kasumi
