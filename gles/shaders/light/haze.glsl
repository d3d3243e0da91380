// Attenuation of a path by two Gauss nodes per channel (physics 4). In kilometres, which fit mediump.
uniform vec3 haze_weight[2];
uniform vec3 haze_rayleigh_per_km[2];
uniform vec3 haze_mie_per_km[2];

// path: density-weighted lengths for Rayleigh and Mie, and the optical depth of fog, which is the same for all nodes.
vec3 attenuation(vec3 path) {
  return haze_weight[0] * exp(-(haze_rayleigh_per_km[0] * path.x + haze_mie_per_km[0] * path.y + path.z)) +
         haze_weight[1] * exp(-(haze_rayleigh_per_km[1] * path.x + haze_mie_per_km[1] * path.y + path.z));
}
