// How a texel of the object's layer is stored: rgb holds square roots, which spend their bits as the eye does and are
// half of the way to any encoding. Alpha up to one half is half of the coverage; above it the object covers the pixel
// whole and alpha holds the pixel's dither instead, which saves the covered pixels a look at the pattern.
float stored_alpha(float coverage, float dither_steps) {
  return coverage > 0.9995 ? 0.75 + 0.49 * dither_steps : 0.5 * coverage;
}
float coverage_in(float alpha) { return min(2.0 * alpha, 1.0); }
float dither_in(float alpha) { return (alpha - 0.75) / 0.49; }
