// How a texel of the object's layer is stored: rgb holds square roots, which distribute precision perceptually and are
// the first step towards any encoding (response.glsl). Alpha up to one half is half of the coverage; above it the
// object covers the whole pixel and alpha holds the pixel's dither instead, which saves covered pixels a lookup of the
// pattern.
#include "lanes.glsl"

const float kCovered = 0.9995;      // coverage from which a pixel counts as fully covered
const float kCoveredAlpha = 0.75;   // alpha for a dither of 0; half a step either way stays between .5 and 1
const float kAlphaPerStep = 0.49;
float stored_alpha(float coverage, float dither_steps) {
  return EITHER(coverage > kCovered, kCoveredAlpha + kAlphaPerStep * dither_steps, 0.5 * coverage);
}
float coverage_in(float alpha) { return min(2.0 * alpha, 1.0); }
float dither_in(float alpha) { return (alpha - kCoveredAlpha) / kAlphaPerStep; }
