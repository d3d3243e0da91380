// One picture of the sky, with the sun's position when it was taken.
#pragma once

#include <string>

#include "estimator/atmosphere.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

struct SunMoment {
  std::string name;  // for people
  SkyPicture picture;
  SunDirection sun{0, 0, 1};
};

}  // namespace kasumi
