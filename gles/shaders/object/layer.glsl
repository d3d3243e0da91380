// How a texel of the object's layer is stored: rgb holds square roots, which spend their bits as the eye does and are
// half of the way to any encoding. Alpha up to one half is half of the coverage; above it the object covers the pixel
// whole and alpha holds the pixel's dither instead, which saves the covered pixels a look at the pattern.
const float kCovered = 0.9995;      // coverage from which a pixel counts as covered whole
const float kCoveredAlpha = 0.75;   // of a dither of 0; half a step of it either way stays between .5 and 1
const float kAlphaPerStep = 0.49;
float stored_alpha(float coverage, float dither_steps) {
  return coverage > kCovered ? kCoveredAlpha + kAlphaPerStep * dither_steps : 0.5 * coverage;
}
float coverage_in(float alpha) { return min(2.0 * alpha, 1.0); }
float dither_in(float alpha) { return (alpha - kCoveredAlpha) / kAlphaPerStep; }
