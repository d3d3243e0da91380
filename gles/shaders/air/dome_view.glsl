// The direction of a vertex of the sky, and where a direction is drawn.
#include "sky_text.glsl"

uniform mat3 camera_to_world;
uniform float focal_px;
uniform vec2 place_to_clip;

vec3 view_of(vec2 place) {
#if defined(FISHEYE)
  return camera_to_world * fisheye_ray(place, focal_px);
#elif defined(EQUIRECTANGULAR)
  return camera_to_world * equirectangular_ray(place, focal_px);
#else
  return camera_to_world * perspective_ray(place, focal_px);
#endif
}

vec4 clip_of(vec3 direction) {
  vec3 ray = direction * camera_to_world;  // multiplied from the left: the transpose is the inverse
#if defined(FISHEYE)
  return vec4(fisheye_place(ray, focal_px) * place_to_clip, 0.0, 1.0);
#elif defined(EQUIRECTANGULAR)
  return vec4(equirectangular_place(ray, focal_px) * place_to_clip, 0.0, 1.0);
#else
  vec3 place = perspective_place(ray, focal_px);
  return vec4(place.xy * place_to_clip, 0.0, place.z);
#endif
}
