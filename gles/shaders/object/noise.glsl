// The camera's noise in linear light: of variance shot L + read^2, from a pattern of unit normals.
#if defined(NOISE)
uniform sampler2D noise_pattern;
uniform vec3 noise_shot;
uniform vec3 noise_read2;
varying vec2 v_noise;

// Where the object covers the pixel in part, the camera's picture brings (1 - coverage)^2 of the variance with it.
vec3 noisy(vec3 light, float coverage) {
  vec3 normal = texture2D(noise_pattern, v_noise).rgb * 8.0 - 4.0;
  vec3 deviation = sqrt((noise_shot * light + noise_read2) * (coverage * (2.0 - coverage)));
  return max(light + deviation * normal, 0.0);
}
#endif
