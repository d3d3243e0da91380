// What the object's pixels depend on besides its layer and what is behind them.
#pragma once

#include "gles/scene.hpp"

namespace kasumi {

struct ObjectLook {
  AirlightGrid measured;
  SensorNoise noise;
};

// Drawn with the one or the other, no pixel differs by more than half a step of 8 bits, nor its noise by more than 5 %;
// the noise's pattern may be another.
bool look_alike(const ObjectLook& a, const ObjectLook& b);

}  // namespace kasumi
