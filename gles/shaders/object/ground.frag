// The object's shadow on the real ground. The ground appears as L Gamma + (1 - Gamma) Linf; the shadow scales its own
// light L by `kept` and leaves the airlight unchanged. The layer has one alpha for three channels: it is green's, which
// dominates brightness, and is exact on any ground; the differences of red and blue go into N, and are exact on ground
// of the proxy's colour. Ground that the sun does not reach has no sunlight to lose; at the object's foot it loses the
// light of the sky that the object hides.
#if !defined(FINAL_COLOUR) || defined(HAZE_PER_FRAGMENT)
#include "haze.glsl"
#endif
#include "dither.glsl"
#if defined(FINAL_COLOUR)
#include "response.glsl"
#include "camera_picture.glsl"
#else
#include "scene_depth.glsl"
#endif
#include "sun.glsl"
#include "sky_atlas.glsl"
#include "fog_light.glsl"
#include "sun_shadow.glsl"

uniform vec4 base_colour;
varying vec3 v_normal;
#if defined(HAZE_PER_FRAGMENT)
varying vec3 v_path;
#endif
#if defined(FINAL_COLOUR)
#if !defined(NO_AIR)
varying vec3 v_airlight;
#endif
uniform mat3 fragment_to_picture;
#if defined(FOREGROUND)
uniform sampler2D foreground;
#endif
#else
uniform vec3 horizon_patch[4];
uniform mat3 fragment_to_patch;
uniform float layer_unit;
#if defined(GROUND_SUNLIGHT)
uniform sampler2D ground_sunlight;
uniform mat3 fragment_to_sunlight;
#endif
#if defined(FOOT_SHADE)
uniform sampler2D foot_shade;
varying vec2 v_foot;
#endif
#endif

const float kLeastShadow = 0.0005;  // fraction of the light below which no shadow is drawn
const float kMapOfGround_m = 10.0;  // tolerance against being hidden, since the depth map contains the ground itself

void main() {
  vec3 normal = normalize(v_normal);
  if (!gl_FrontFacing) normal = -normal;
  vec3 sun = sun_here(normal), sky = sky_here(normal);
#if defined(GROUND_SUNLIGHT)
  sun *= texture2D(ground_sunlight, (fragment_to_sunlight * vec3(gl_FragCoord.xy, 1.0)).xy).r;
#endif
  vec3 own = sun + sky, lost = (1.0 - sun_seen(normal)) * sun;
#if defined(FOOT_SHADE)
  lost += (1.0 - texture2D(foot_shade, v_foot).r) * sky;
#endif
  vec3 kept = 1.0 - lost / max(own, 1e-6);
#if defined(FINAL_COLOUR)
  vec2 place = (fragment_to_picture * vec3(gl_FragCoord.xy, 1.0)).xy;
#if defined(FOREGROUND)
  kept = mix(vec3(1.0), kept, texture2D(foreground, place).r);
#endif
  if (kept.g > 1.0 - kLeastShadow) discard;
  vec3 light = light_of(clamp(camera_at(place), 0.0, 1.0)) * kept;
#if defined(HAZE_PER_FRAGMENT)
  light += v_airlight * (1.0 - attenuation(v_path)) * (1.0 - kept);
#elif !defined(NO_AIR)
  light += v_airlight * (1.0 - kept);
#endif
  gl_FragColor = vec4(encoded(light) + dither(gl_FragCoord.xy) / 255.0, 1.0);
#else
  float alpha = 1.0 - kept.g;
  if (alpha < kLeastShadow) discard;
#if defined(SCENE_DEPTH)
  if (is_hidden(1.0 / gl_FragCoord.w - kMapOfGround_m)) discard;
#endif
#if defined(NO_AIR)
  vec3 passed_on = vec3(1.0);
#else
  vec3 passed_on = attenuation(v_path);
#endif
  vec2 at = (fragment_to_patch * vec3(gl_FragCoord.xy, 1.0)).xy;
  vec3 rho = in_channels(base_colour.rgb) * own /
             (horizon_patch[0] + horizon_patch[1] * at.x + (horizon_patch[2] + horizon_patch[3] * at.x) * at.y);
  vec3 seen = max(alpha * (1.0 - passed_on) + (kept - kept.g) * rho * passed_on, 0.0) / layer_unit;
#if defined(LAYER_IN_8_BITS)
  seen += dither(gl_FragCoord.xy) / 255.0;
#endif
  gl_FragColor = vec4(seen, alpha);
#endif
}
