// The light that falls on surfaces.
uniform vec3 sun_direction;
uniform vec3 sun_light;        // irradiance / pi
uniform mat3 albedo_to_channels;
uniform vec3 sky_light[9];     // irradiance / pi, with the constants of the SH basis

vec3 in_channels(vec3 reflectance) { return clamp(albedo_to_channels * reflectance, 0.0, 1.0); }

// The sky's harmonics of order 1 and 2 towards n.
vec3 first_order(vec3 n) { return sky_light[1] * n.y + sky_light[2] * n.z + sky_light[3] * n.x; }
vec3 second_order(vec3 n) {
  return sky_light[4] * n.x * n.y + sky_light[5] * n.y * n.z + sky_light[6] * (3.0 * n.z * n.z - 1.0) +
         sky_light[7] * n.x * n.z + sky_light[8] * (n.x * n.x - n.y * n.y);
}

// Irradiance of the sky, of the sun, on a surface of normal n, over pi.
vec3 from_sky(vec3 n) { return max(sky_light[0] + first_order(n) + second_order(n), 0.0); }
vec3 from_sun(vec3 n) { return sun_light * max(dot(n, sun_direction), 0.0); }
