// What fog makes of the light of sun and sky on its way down to a surface within it (physics 6): the sun's rays thin out,
// and most of what they lose comes from all sides instead. Needs sun.glsl and sky_atlas.glsl.
#if defined(FOG_LIGHT)
varying float v_fog_above;  // optical depth, straight up

// Of droplets that scatter with a mean cosine g = .85: two-stream, .75 (1 - g); and what the rays lose, 1 - g^2, since
// the rest stays near to them (delta-Eddington).
const float kBackwards = 0.11;
const float kAside = 0.28;
const float kLowestSun = 0.03;

float sun_through_fog() { return exp(-kAside * v_fog_above / max(sun_direction.z, kLowestSun)); }
float light_through_fog() { return 1.0 / (1.0 + kBackwards * v_fog_above); }
// Radiance from all sides.
vec3 fog_glow() { return sun_light * (max(sun_direction.z, 0.0) * max(light_through_fog() - sun_through_fog(), 0.0)); }

vec3 sun_here(vec3 n) { return from_sun(n) * sun_through_fog(); }
vec3 sky_here(vec3 n) { return from_sky(n) * light_through_fog() + fog_glow(); }
#else
vec3 sun_here(vec3 n) { return from_sun(n); }
vec3 sky_here(vec3 n) { return from_sky(n); }
#endif
