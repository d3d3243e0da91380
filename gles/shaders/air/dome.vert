// The sky at the mesh's vertices; gles/air/dome_mesh.cpp makes the mesh fine enough for linear interpolation.
#if defined(PER_FRAGMENT)
#include "dome_place.glsl"
#else
#include "dome_view.glsl"
#include "dome_sky.glsl"
#endif

attribute vec2 position;  // right and down of the middle, pixels
varying vec2 v_place;
#if !defined(PER_FRAGMENT)
varying vec3 v_shown;
#endif

void main() {
  v_place = position;
#if !defined(PER_FRAGMENT)
  vec3 view = view_of(position);
  v_shown = shown(sky_light(view), view);
#endif
  gl_Position = vec4(position * place_to_clip, 0.0, 1.0);
}
