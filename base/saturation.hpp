// Encoded levels from which a channel counts as saturated. Scaling, demosaicing and noise leave partly saturated pixels
// just below the last code, so each use needs its own margin.
#pragma once

namespace kasumi {

// Of 0..1.
constexpr double kSaturated =
    0.98;  // in an exposure stack: other exposures cover for it, so a wide margin costs nothing
constexpr double kSaturatedSky = 0.985;  // sky picture
constexpr double kSaturatedSun = 0.97;   // the dimmest channel of the sun's core
constexpr double kSaturatedBox =
    254.5 / 255.0;  // landmarks' boxes: only the last code, since a few saturated pixels are tolerable

// Of 255.
constexpr int kSaturatedHorizon = 252;  // any channel of the scene camera's picture
constexpr int kWhiteOut = 235;          // brightness: white in limited range, and near white in full range

}  // namespace kasumi
