// How much of an even light around a rough mirror it gives back: integrals over the microfacet distribution that glTF
// prescribes (GGX, Smith's height-correlated masking), done once on the CPU (split sum, Karis 2013).
#pragma once

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"

namespace kasumi {

// A surface of Fresnel reflectance F = f0 + (f90 - f0) (1 - v.h)^5 gives back f0 (all - edge) + f90 edge of the light,
// seen at an angle of cosine `across` > 0 to its normal, reflected once.
struct GivenBack {
  double all = 1.0;
  double edge = 0.0;
  // Mean direction of what is given back, of length 1 when all goes one way: along the normal, and away from the eye
  // at right angles to it.
  double along = 1.0;
  double aside = 0.0;
};
GivenBack given_back(double across, double roughness);

// The cosine between normal and facet that a share of GGX's facets lie within; alpha: roughness squared.
double facet_cosine(double share, double alpha);

// The mean cosine to its middle of the lobe that a mirror of this roughness has when seen head-on: 1 of a smooth one,
// 2/3 (Lambert's) at roughness 1.
double mean_cosine(double roughness);

// What of the filtered surroundings a mirror shows: those around mix(normal, mirror image, lean), as blurred as seen
// head-on at another roughness, so that the lobe's mean direction is kept in full. (Lobes lean and stretch with the
// angle they are seen at.)
struct SeenAs {
  double lean = 1.0;
  double roughness = 0.0;
};
SeenAs seen_as(double across, const GivenBack& back);

// `all`, `edge`, `lean` and `roughness` over the square root of `across` (columns) and roughness (rows), each 0 .. 1.
constexpr int kReflectionTableSize = 32;
Image<glm::u8vec4> reflection_table();

}  // namespace kasumi
