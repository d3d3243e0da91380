// One image circle from many pictures of a camera that stands still.
#pragma once

#include <optional>
#include <vector>

#include "calib/mask/image_circle.hpp"

namespace kasumi {

struct SizedCircle {
  int width = 0;  // of the picture
  int height = 0;
  std::optional<FoundCircle> found;
};

// The circle to use for each picture, in their order. Where the best circles of two or more pictures of one size agree,
// all pictures that see it get their median, and so do those in which nothing certain was found if there is only one
// such circle. A picture that is sure of quite another circle keeps it: another camera, or a crop that moved. Pictures
// of different cameras may be mixed. `confidence` is that of the circle given.
std::vector<std::optional<FoundCircle>> circles_of_fixed_cameras(const std::vector<SizedCircle>& pictures);

}  // namespace kasumi
