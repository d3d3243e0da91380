// The building's light. Layer: premultiplied N = rho Gamma + 1 - Gamma (physics 6). FINAL_COLOUR: as the camera would
// have encoded it.
varying vec3 v_normal;
varying vec2 v_texture;
varying vec4 v_colour;

uniform vec4 base_colour;
#if defined(TEXTURED)
uniform sampler2D base_texture;
#endif
#if defined(ALPHA_TEST)
uniform float alpha_cutoff;
#endif
uniform vec3 sun_direction;
uniform vec3 sun_light;        // irradiance / pi
uniform mat3 albedo_to_channels;
uniform vec3 sky_light[9];     // irradiance / pi, with the constants of the SH basis

#if defined(HAZE_PER_FRAGMENT)
varying vec2 v_path_km;
#endif
#if defined(FINAL_COLOUR)
varying vec3 v_gain;
#if !defined(NO_AIR)
varying vec3 v_airlight;
#endif
#if defined(FOREGROUND)
uniform sampler2D foreground;
uniform mat3 fragment_to_picture;
#endif
#else
uniform vec3 horizon_patch[4];   // bilinear over the tile: 1, x, y, x y
uniform mat3 fragment_to_patch;  // 0..1 across the tile
uniform float layer_unit;      // N that full scale of the layer stands for
#endif

vec4 albedo() {
  vec4 surface = base_colour * v_colour;
#if defined(TEXTURED)
  vec4 texel = texture2D(base_texture, v_texture);
#if defined(DECODE_TEXTURE)
  texel.rgb = mix(texel.rgb / 12.92, pow((texel.rgb + 0.055) / 1.055, vec3(2.4)), step(0.04045, texel.rgb));
#endif
  surface *= texel;
#endif
  return surface;
}

// Lambert under sun and sky.
vec3 irradiance_over_pi(vec3 n) {
  vec3 sky = sky_light[0] + sky_light[1] * n.y + sky_light[2] * n.z + sky_light[3] * n.x + sky_light[4] * n.x * n.y +
             sky_light[5] * n.y * n.z + sky_light[6] * (3.0 * n.z * n.z - 1.0) + sky_light[7] * n.x * n.z +
             sky_light[8] * (n.x * n.x - n.y * n.y);
  return sun_light * max(dot(n, sun_direction), 0.0) + max(sky, 0.0);
}

void main() {
  vec4 surface = albedo();
#if defined(ALPHA_TEST)
  if (surface.a < alpha_cutoff) discard;
#endif
#if defined(ALPHA_BLEND)
  float alpha = clamp(surface.a, 0.0, 1.0);
#else
  float alpha = 1.0;
#endif
  vec3 n = normalize(v_normal) * (gl_FrontFacing ? 1.0 : -1.0);
  vec3 radiance = clamp(albedo_to_channels * surface.rgb, 0.0, 1.0) * irradiance_over_pi(n);

#if defined(FINAL_COLOUR)
#if defined(NO_AIR)
  vec3 light = radiance * v_gain;
#elif defined(HAZE_PER_FRAGMENT)
  vec3 passed = attenuation(v_path_km);
  vec3 light = radiance * v_gain * passed + v_airlight * (1.0 - passed);
#else
  vec3 light = radiance * v_gain + v_airlight;
#endif
#if defined(FOREGROUND)
  vec2 place = (fragment_to_picture * vec3(gl_FragCoord.xy, 1.0)).xy;
  float open_view = texture2D(foreground, place).r;
  if (open_view == 0.0) discard;
  light = mix(light_of(clamp(camera_at(place), 0.0, 1.0)), light, open_view);
#endif
  gl_FragColor = vec4(encoded(light) + dither(gl_FragCoord.xy) / 255.0, 1.0) * alpha;
#else
#if defined(NO_AIR)
  vec3 passed = vec3(1.0);
#else
  vec3 passed = attenuation(v_path_km);
#endif
  vec2 at = (fragment_to_patch * vec3(gl_FragCoord.xy, 1.0)).xy;
  vec3 rho = radiance / (horizon_patch[0] + horizon_patch[1] * at.x + (horizon_patch[2] + horizon_patch[3] * at.x) * at.y);
  vec3 seen = (rho * passed + 1.0 - passed) / layer_unit;
#if defined(LAYER_IN_8_BITS)
  seen += dither(gl_FragCoord.xy) / 255.0;
#endif
  gl_FragColor = vec4(seen, 1.0) * alpha;
#endif
}
