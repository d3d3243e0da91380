// Encoded levels from which a channel says only "so much light or more". What lies below the last code but near it is
// mixed with saturated neighbours by scaling, demosaicing and noise: how wide a margin that takes differs with what is
// asked of the pixels.
#pragma once

namespace kasumi {

// Of 0..1.
constexpr double kSaturated = 0.98;  // in a stack of exposures: the others tell, so that a wide margin costs nothing
constexpr double kSaturatedSky = 0.985;  // in the sky's picture, whose elements are means of pixels: any channel
constexpr double kSaturatedSun = 0.97;   // the dimmest channel of the sun's core
constexpr double kSaturatedBox = 254.5 / 255.0;  // in landmarks' boxes: the last code alone, for a few may be left in

// Of 255.
constexpr int kSaturatedHorizon = 252;  // any channel of the scene's picture
constexpr int kWhiteOut = 235;          // brightness; white of limited range, and a full-range picture nowhere darker

}  // namespace kasumi
