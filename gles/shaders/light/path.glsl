// Lengths of a straight path weighted by the air's density relative to sea level (physics 4, slanted paths).
uniform vec2 observer_density;          // exp(-h0 / H): Rayleigh, Mie
uniform vec2 inverse_scale_height_km;
uniform float fog_per_km;              // at the fog's base
uniform float observer_above_fog;      // height above its base, in scale heights
uniform float inverse_fog_height_km;

// Mean of exp(-t) over t in 0..x: (1 - exp(-x)) / x, by its series where cancellation would lose digits.
float mean_density(float x) {
  return abs(x) < 0.1 ? 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0))) : (1.0 - exp(-x)) / x;
}

// The path argument of attenuation() in haze.glsl.
vec3 path_through_air(float range_km, float climb_km) {
  vec2 heights = climb_km * inverse_scale_height_km;
  // Fog may change by many e-folds along a path. Evaluated from its lower end upwards, only opaque fog would overflow,
  // and that is clamped to the range of half floats.
  float above = climb_km * inverse_fog_height_km;
  float lower = observer_above_fog + min(above, 0.0);
  float fog = min(range_km * fog_per_km * exp(clamp(-lower, -80.0, 40.0)) * mean_density(abs(above)), 60.0);
  return vec3(range_km * observer_density * vec2(mean_density(heights.x), mean_density(heights.y)), fog);
}

// Optical depth of the fog straight up from there, within the range of half floats.
float fog_straight_up(float climb_km) {
  float lower = observer_above_fog + climb_km * inverse_fog_height_km;
  return min(fog_per_km / inverse_fog_height_km * exp(clamp(-lower, -80.0, 40.0)), 60.0);
}
