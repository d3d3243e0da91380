// Whether a picture was taken by daylight in colours. By night and in infrared light Koschmieder's law says nothing:
// lamps light the air, leaves are as bright as the sky, noise hides what is dark.
#pragma once

#include <optional>
#include <string>

#include <glm/vec3.hpp>

#include "base/geometry.hpp"
#include "base/image.hpp"

namespace kasumi {

// What a picture itself shows of that. Levels are encoded, 0..1.
struct DaylightLook {
  double coloured = 0.0;       // share of pixels whose channels differ by more than 3/255
  double noise = 0.0;          // standard deviation of one pixel's green in the quietest quarter of the picture
  double sky = 0.0;            // median of the upper half
  double brightest_sky = 0.0;  // 95 % of the upper half are darker
  double range = 0.0;          // between the darkest and the brightest twentieth
  double land = 0.0;           // median of the lower half
  double lamps = 0.0;          // share of the lower half that is at full scale
};
DaylightLook look_for_daylight(const Image<glm::vec3>& encoded);

// Why contrasts in this picture say nothing of visibility: "infrared or black and white: ...", "by night: ..."; empty:
// daylight. `sun`: where known. A picture of grey fog by day is quiet, bright and without contrast, and not refused.
std::string why_not_daylight(const DaylightLook& look, const std::optional<Direction>& sun = {});

}  // namespace kasumi
