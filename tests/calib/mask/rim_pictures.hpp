// Fisheye pictures whose image circle is known, with all that makes its rim hard to see, and pictures without one.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/mask/image_circle.hpp"

namespace kasumi::test {

// Nothing of the second was looked at while the first was worked with.
enum class RimSet { development, held_out };

struct RimPicture {
  Image<Rgb8> pixels;
  std::optional<ImageCircle> circle;  // empty: there is none
  double shown = 0.0;                 // share of the rim inside the frame
  std::string remark;
};

// With a circle: whole or cut on one to four sides.
RimPicture draw_rim(RimSet set, std::uint64_t seed);
// Without: landscapes, skies, vignetted photographs, frames, windows, boards, noise.
RimPicture draw_without_rim(RimSet set, std::uint64_t seed);

}  // namespace kasumi::test
