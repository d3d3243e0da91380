// Two numbers of 0..1 in the four bytes of a texel, 16 bits each, for 8-bit targets and textures. Samplers must be
// declared highp: their default is low precision, which may round to half floats.
vec2 from_bytes(vec4 texel) {
  return vec2(dot(texel.rg, vec2(65280.0, 255.0)), dot(texel.ba, vec2(65280.0, 255.0))) / 65535.0;
}
vec4 in_bytes(vec2 values) {
  vec2 whole = floor(clamp(values, 0.0, 1.0) * 65535.0 + 0.5);
  vec2 high = floor((whole + 0.5) / 256.0);
  return vec4(high.x, whole.x - 256.0 * high.x, high.y, whole.y - 256.0 * high.y) / 255.0;
}

// Rounds to a half float's 11 bits, because some drivers truncate; the last factor keeps them from truncating further.
vec4 in_halves(vec4 values) {
  vec4 half_step = exp2(floor(log2(max(values, 0.0001))) - 10.0);
  return floor(values / half_step + 0.5) * half_step * 1.000001;
}
