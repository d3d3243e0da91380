// The sun's disc as rings of points around its middle; the last two rings lie half a pixel inside and outside its edge.
#include "dome_view.glsl"
#include "dome_sky.glsl"

attribute vec2 position;  // radius as a fraction of the disc's (2: outside the edge); angle around the middle
uniform float sun_radius;
uniform float blur;  // half a pixel, in radii
varying vec2 v_place;
varying vec3 v_shown;

void main() {
  vec3 side = normalize(abs(sun.z) < 0.9 ? cross(sun, vec3(0.0, 0.0, 1.0)) : cross(sun, vec3(1.0, 0.0, 0.0)));
  vec3 up = cross(side, sun);
  bool beyond = position.x > 1.5;
  float off = beyond ? 1.0 + blur : position.x * max(1.0 - blur, 0.0);
  vec3 view = normalize(sun + off * sun_radius * (cos(position.y) * side + sin(position.y) * up));
  v_shown = shown(sky_light(view) + (beyond ? vec3(0.0) : sun_disc_light(sun_luminance, off)), view);
  gl_Position = clip_of(view);
  v_place = gl_Position.xy / (max(gl_Position.w, 0.001) * place_to_clip);
}
