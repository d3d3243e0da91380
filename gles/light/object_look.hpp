// What the object's pixels depend on besides its layer and what is behind them.
#pragma once

#include "gles/scene.hpp"

namespace kasumi {

struct ObjectLook {
  AirlightGrid measured;
  SensorNoise noise;
};

// Drawn with the one or the other, no pixel's light differs by more than .4 %, half a step of 8 bits behind a camera's
// response (one step where that is linear), nor its noise by more than 5 %; the noise's pattern may be another.
bool look_alike(const ObjectLook& a, const ObjectLook& b);

}  // namespace kasumi
