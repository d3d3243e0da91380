#if defined(PER_FRAGMENT)
#include "dome_view.glsl"
#include "dome_sky.glsl"
#endif
#include "dither.glsl"

varying vec2 v_place;
#if !defined(PER_FRAGMENT)
varying vec3 v_shown;
#endif
#if defined(FISHEYE)
uniform float circle_px;
#endif

void main() {
#if defined(PER_FRAGMENT)
  vec3 view = view_of(v_place);
  vec3 colour = shown(sky_light(view), view);
#else
  vec3 colour = v_shown;
#endif
  colour += dither(gl_FragCoord.xy) / 255.0;
#if defined(FISHEYE)
  // In radii: the square of pixels is infinite in 16 bits.
  colour *= clamp(circle_px * (1.0 - length(v_place / circle_px)) + 0.5, 0.0, 1.0);
#endif
  gl_FragColor = vec4(colour, 1.0);
}
