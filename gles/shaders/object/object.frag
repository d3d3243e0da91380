// The building's light. Layer: premultiplied N = rho Gamma + 1 - Gamma (physics 6). FINAL_COLOUR: encoded as by the
// camera.
#if !defined(FINAL_COLOUR) || defined(HAZE_PER_FRAGMENT)
#include "haze.glsl"
#endif
#include "dither.glsl"
#if defined(FINAL_COLOUR)
#include "response.glsl"
#include "camera_picture.glsl"
#include "saturation.glsl"
#else
#include "scene_depth.glsl"
#endif
#include "light.glsl"

#if defined(HAZE_PER_FRAGMENT)
varying vec3 v_path;
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
uniform float layer_unit;      // N at full scale of the layer
#endif

#if !defined(FINAL_COLOUR)
// The sun in a mirror exceeds the range of half floats; it is white either way.
const float kBrightest = 60000.0;
#endif

void main() {
  Surface surface = surface_here();
#if defined(ALPHA_BLEND)
  float alpha = clamp(surface.colour.a, 0.0, 1.0);
#else
  float alpha = 1.0;
#endif
  vec3 radiance = radiance_of(surface);

#if defined(FINAL_COLOUR)
#if defined(NO_AIR)
  vec3 light = radiance * v_gain;
#elif defined(HAZE_PER_FRAGMENT)
  vec3 passed = attenuation(v_path);
  vec3 light = radiance * v_gain * passed + v_airlight * (1.0 - passed);
#else
  vec3 light = radiance * v_gain + v_airlight;
#endif
#if defined(SATURATED)
  light = saturated(light);
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
  vec3 passed = attenuation(v_path);
#endif
  vec2 at = (fragment_to_patch * vec3(gl_FragCoord.xy, 1.0)).xy;
  vec3 rho = radiance / (horizon_patch[0] + horizon_patch[1] * at.x + (horizon_patch[2] + horizon_patch[3] * at.x) * at.y);
  vec3 seen = min((rho * passed + 1.0 - passed) / layer_unit, kBrightest);
#if defined(LAYER_IN_8_BITS)
  seen += dither(gl_FragCoord.xy) / 255.0;
#endif
#if defined(SCENE_DEPTH)
  if (is_hidden(1.0 / gl_FragCoord.w)) discard;
#endif
  gl_FragColor = vec4(seen, 1.0) * alpha;
#endif
}
