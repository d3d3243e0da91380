// Outlines of a range map, moved to the picture's own edges. Stereo and depth sensors see where a thing ends to some
// pixels only, and haze makes that ragged line visible: what is near stays clear on one side of it, what is far fades
// on the other.
#pragma once

#include <glm/vec3.hpp>

#include "base/image.hpp"

namespace kasumi {

// Within `reach_px` of a step from surface to surface each range becomes the weighted median of those around it, by
// likeness of colour and nearness (Ma 2013, Constant time weighted median filtering: the joint bilateral filter's
// weights, a median in place of the mean, which would make ranges between two surfaces where nothing stands). Elsewhere
// ranges stay as they are. `picture`: encoded, of the map's size. reach_px < 1: nothing is done.
void move_outlines_to_edges(const Image<glm::vec3>& picture, Image<float>& range, int reach_px);

}  // namespace kasumi
