// The camera's noise in linear light: variance shot L + read^2, from a pattern of standard normal numbers.
#if defined(NOISE)
uniform sampler2D noise_pattern;
uniform vec3 noise_shot;
uniform vec3 noise_read2;
varying vec2 v_noise;

// In partly covered pixels the camera's picture already contributes (1 - coverage)^2 of the variance.
vec3 noisy(vec3 light, float coverage) {
  vec3 normal = texture2D(noise_pattern, v_noise).rgb * 8.0 - 4.0;
  vec3 deviation = sqrt((noise_shot * light + noise_read2) * (coverage * (2.0 - coverage)));
  return max(light + deviation * normal, 0.0);
}
#endif
