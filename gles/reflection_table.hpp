// How much of an even light around a rough mirror it gives back, and how far its roughness smears what it mirrors:
// integrals over the microfacet distribution that glTF prescribes (GGX, Smith's height-correlated masking), done once
// on the CPU (split sum, Karis 2013).
#pragma once

#include "base/result.hpp"
#include "gles/objects.hpp"

namespace kasumi {

// A surface of Fresnel reflectance F = f0 + (f90 - f0) (1 - v.h)^5 gives back f0 (all - edge) + f90 edge of the light,
// seen at an angle of cosine `across` > 0 to its normal, reflected once.
struct GivenBack {
  double all = 1.0;
  double edge = 0.0;
};
GivenBack given_back(double across, double roughness);

// What is left of the sky's spherical harmonics of order 1 and 2 in the mirror image, seen head-on: 1 and 1 of a smooth
// mirror, 2/3 and 1/4 (Lambert's) at roughness 1.
struct Smeared {
  double first = 1.0;
  double second = 1.0;
};
Smeared smeared(double roughness);

// All four over the square root of `across` and roughness, 32 x 32 texels of 8 bits, in the order above.
Result<GlTexture> make_reflection_table(int unit);

}  // namespace kasumi
