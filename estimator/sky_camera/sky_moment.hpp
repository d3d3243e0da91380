// The sky once: a picture of it, and where the sun stood.
#pragma once

#include <string>

#include "estimator/atmosphere.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

struct SkyMoment {
  std::string name;  // for people
  SkyPicture picture;
  SunDirection sun{0, 0, 1};
};

}  // namespace kasumi
