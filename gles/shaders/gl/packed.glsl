// Two numbers of 0..1 in the four bytes of a texel, 16 bits each, for targets and textures that have nothing finer.
// Samplers read in low precision unless they are declared highp, and half floats are then what comes of the bytes.
vec2 from_bytes(vec4 texel) {
  return vec2(dot(texel.rg, vec2(65280.0, 255.0)), dot(texel.ba, vec2(65280.0, 255.0))) / 65535.0;
}
vec4 in_bytes(vec2 values) {
  vec2 whole = floor(clamp(values, 0.0, 1.0) * 65535.0 + 0.5);
  vec2 high = floor((whole + 0.5) / 256.0);
  return vec4(high.x, whole.x - 256.0 * high.x, high.y, whole.y - 256.0 * high.y) / 255.0;
}

// To a half's 11 bits here, because some drivers cut instead of rounding; the last factor keeps them from cutting more.
vec4 in_halves(vec4 values) {
  vec4 half_step = exp2(floor(log2(max(values, 0.0001))) - 10.0);
  return floor(values / half_step + 0.5) * half_step * 1.000001;
}
