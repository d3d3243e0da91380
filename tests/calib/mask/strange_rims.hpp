// Fisheye pictures as strangers publish them: surrounds of any colour, rings, flare, text, walls, any crop.
#pragma once

#include <cstdint>

#include "tests/calib/mask/rim_pictures.hpp"

namespace kasumi::test {

struct StrangeRim {
  RimPicture picture;                  // its circle: in square pixels, as FoundCircle gives it
  std::optional<ImageCircle> horizon;  // where a ring of land lies inside it
  double pixel_aspect = 1.0;
};
StrangeRim draw_strange_rim(RimSet set, std::uint64_t seed);

}  // namespace kasumi::test
