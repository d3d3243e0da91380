// Lengths of a straight path weighted by the air's density, relative to sea level (physics 4, slanted paths).
uniform vec2 observer_density;          // exp(-h0 / H): Rayleigh, Mie
uniform vec2 inverse_scale_height_km;

// Mean of exp(-t) over t in 0..x: (1 - exp(-x)) / x, by its series where the difference would cancel.
float mean_density(float x) {
  return abs(x) < 0.1 ? 1.0 - x * (0.5 - x * (1.0 / 6.0 - x * (1.0 / 24.0 - x / 120.0))) : (1.0 - exp(-x)) / x;
}

vec2 weighted_path_km(float range_km, float climb_km) {
  vec2 heights = climb_km * inverse_scale_height_km;
  return range_km * observer_density * vec2(mean_density(heights.x), mean_density(heights.y));
}
