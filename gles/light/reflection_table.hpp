// The directional albedo of rough mirrors under uniform light: integrals over glTF's microfacet distribution (GGX,
// Smith's height-correlated masking), computed once on the CPU (split sum, Karis 2013).
#pragma once

#include <glm/gtc/type_precision.hpp>

#include "base/image.hpp"

namespace kasumi {

// A surface of Fresnel reflectance F = f0 + (f90 - f0) (1 - v.h)^5 reflects f0 (all - edge) + f90 edge of the light in
// a single bounce, seen at an angle of cosine `across` > 0 to its normal.
struct DirectionalAlbedo {
  double all = 1.0;
  double edge = 0.0;
  // Mean direction of the reflected light, of length 1 if it all has one direction: component along the normal, and
  // tangential component away from the eye.
  double along = 1.0;
  double aside = 0.0;
};
DirectionalAlbedo directional_albedo(double across, double roughness);

// The cosine to the normal within which this share of GGX facets lies; alpha: roughness squared.
double facet_cosine(double share, double alpha);

// The mean cosine of the lobe about its axis at normal incidence: 1 for a smooth mirror, 2/3 (Lambert's) at roughness
// 1.
double mean_cosine(double roughness);

// Where to sample the filtered surroundings for a mirror: in direction mix(normal, mirror direction, lean), at the
// roughness that gives the lobe's mean direction its exact length. (Lobes lean and stretch with the viewing angle.)
struct ReflectionLookup {
  double lean = 1.0;
  double roughness = 0.0;
};
ReflectionLookup reflection_lookup(double across, const DirectionalAlbedo& back);

// `all`, `edge`, `lean` and `roughness` over the square root of `across` (columns) and roughness (rows), each 0 .. 1.
constexpr int kReflectionTableSize = 32;
Image<glm::u8vec4> reflection_table();

}  // namespace kasumi
