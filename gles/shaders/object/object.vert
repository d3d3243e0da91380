// The building's vertices: their projection and the air's effect on the path.
#if defined(FINAL_COLOUR)
#include "airlight.glsl"
#if !defined(HAZE_PER_FRAGMENT)
// Code with uniforms is included only in the stage that uses it, because precisions differ between the stages.
#include "haze.glsl"
#endif
#endif
#include "path.glsl"
#include "lens.glsl"

attribute vec3 position;
attribute vec3 normal;
attribute vec2 texture_place;
attribute vec4 colour;
#if defined(SECOND_PLACE)
attribute vec2 texture_place_2;
varying vec2 v_texture_2;
#endif
#if defined(NORMAL_MAP)
attribute vec4 tangent;
uniform mat3 tangent_to_world;
varying vec4 v_tangent;
#endif
#if defined(REFLECTS)
uniform mat3 camera_to_world;
varying vec3 v_to_eye;
#endif

uniform mat4 model_to_camera;   // metres; composed in double precision
uniform mat3 normal_to_world;
uniform vec3 camera_up;         // the world's vertical in the camera's frame
uniform vec2 focal_px;
uniform vec2 centre_px;
uniform float near_m;
uniform vec2 depth_to_clip;     // clip z = x * depth + y
uniform mat3 pixel_to_clip;     // homogeneous pixels to clip x, y

#if defined(SUN_SHADOW)
uniform mat4 sun_from_model;
varying vec3 v_sun;
#endif
#if defined(FOOT_SHADE)
uniform mat4 foot_from_model;
varying vec2 v_foot;
#endif
varying vec3 v_normal;
varying vec2 v_texture;
varying vec4 v_colour;
#if defined(HAZE_PER_FRAGMENT)
varying vec3 v_path;
#endif
#if defined(FOG_LIGHT)
varying float v_fog_above;
#endif
#if defined(FINAL_COLOUR)
uniform vec3 measured_light[AIRLIGHT_COLUMNS * AIRLIGHT_ROWS];
uniform vec4 measured_place;
uniform vec3 horizon_light[AIRLIGHT_COLUMNS * AIRLIGHT_ROWS];
uniform vec4 horizon_place;
varying vec3 v_gain;       // of the object's radiance
#if !defined(NO_AIR)
varying vec3 v_airlight;
#endif
#endif

void main() {
  vec3 camera = (model_to_camera * vec4(position, 1.0)).xyz;
#if defined(DISTORTED)
  // Points behind the near plane only matter as ends of clipped edges, and are kept finite.
  float depth = max(camera.z, near_m);
  vec2 across = distorted(camera.xy / depth) * depth;
#else
  vec2 across = camera.xy;
#endif
  vec3 pixel = vec3(focal_px * across + centre_px * camera.z, camera.z);
  gl_Position = vec4((pixel_to_clip * pixel).xy, depth_to_clip.x * camera.z + depth_to_clip.y, camera.z);

  v_normal = normal_to_world * normal;
#if defined(SUN_SHADOW)
  v_sun = (sun_from_model * vec4(position, 1.0)).xyz;
#endif
#if defined(FOOT_SHADE)
  v_foot = (foot_from_model * vec4(position, 1.0)).xy;
#endif
  v_texture = texture_place;
  v_colour = colour;
#if defined(SECOND_PLACE)
  v_texture_2 = texture_place_2;
#endif
#if defined(NORMAL_MAP)
  v_tangent = vec4(tangent_to_world * tangent.xyz, tangent.w);
#endif
#if defined(REFLECTS)
  v_to_eye = camera_to_world * (-0.001 * camera);
#endif
#if !defined(NO_AIR)
  vec3 path = path_through_air(0.001 * length(camera), 0.001 * dot(camera_up, camera));
#endif
#if defined(HAZE_PER_FRAGMENT)
  v_path = path;
#endif
#if defined(FOG_LIGHT)
  v_fog_above = fog_straight_up(0.001 * dot(camera_up, camera));
#endif
#if defined(FINAL_COLOUR)
  vec2 seen = pixel.xy / max(camera.z, near_m);
  vec3 airlight = airlight_on(measured_light, measured_place, seen);
  v_gain = airlight / airlight_on(horizon_light, horizon_place, seen);
#if defined(HAZE_PER_FRAGMENT)
  v_airlight = airlight;
#elif !defined(NO_AIR)
  vec3 passed = attenuation(path);
  v_gain *= passed;
  v_airlight = airlight * (1.0 - passed);
#endif
#endif
}
