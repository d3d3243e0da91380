// Land through the air, at the vertices of its mesh.
#include "dome_view.glsl"

attribute vec3 position;  // metres from sea level below the observer
attribute vec3 normal;
attribute vec4 colour;    // reflectance, altitude in metres
uniform AirBetween between;
uniform OlderAir older_air;
uniform float observer_m;
uniform float air_share;  // 0: without air
uniform vec3 sky_lower;
uniform vec3 sky_higher;
uniform vec3 sun;
uniform vec3 sun_luminance;
uniform float exposure;
varying vec2 v_place;
varying vec3 v_shown;

void main() {
  float way = way_between_altitudes(colour.a, between.altitude_m.x, between.altitude_m.y);
  vec3 light = land_light(colour.rgb, dot(normal, sun), normal.z, mix(between.sun_lower, between.sun_higher, way), mix(sky_lower, sky_higher, way));
  vec3 from_observer = position - vec3(0.0, 0.0, observer_m);
  float range_m = length(from_observer);
  vec3 view = from_observer / max(range_m, 0.001);
#if defined(HOFFMAN_PREETHAM)
  vec3 seen = hoffman_preetham_object(older_air, light, range_m, dot(view, sun));
#elif defined(NIELSEN)
  vec3 seen = nielsen_object(older_air, light, colour.a, range_m, dot(view, sun));
#else
  vec3 seen = object_through_air(between, light, observer_m, colour.a, range_m, dot(view, sun), sun.z);
#endif
  v_shown = srgb_encoded(tone_mapped(mix(light, seen, air_share) + sun_glare(sun_luminance, length(view - sun)), exposure));
  gl_Position = clip_of(view);
  v_place = gl_Position.xy / (max(gl_Position.w, 0.001) * place_to_clip);
}
