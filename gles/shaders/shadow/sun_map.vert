// Projects shadow casters as seen from one point of the sun's disc.
#include "sun_maps.glsl"

attribute vec3 position;
#if defined(ALPHA_TEST)
attribute vec2 texture_place;
attribute vec4 colour;
varying vec2 v_texture;
varying float v_alpha;
#endif
uniform mat4 sun_from_model;
uniform float map_number;
#if defined(PACKED_DEPTH)
varying float v_depth;
#endif

void main() {
  vec3 point = (sun_from_model * vec4(position, 1.0)).xyz;
  gl_Position = vec4(2.0 * place_in_map(point, map_number) / sun_map_texels - 1.0, 2.0 * point.z - 1.0, 1.0);
#if defined(ALPHA_TEST)
  v_texture = texture_place;
  v_alpha = colour.a;
#endif
#if defined(PACKED_DEPTH)
  v_depth = point.z;
#endif
}
