// Depth written by the driver, or packed into the four bytes of a colour. Masked materials are cut out.
#if defined(ALPHA_TEST)
uniform vec4 base_colour;
uniform float alpha_cutoff;
varying vec2 v_texture;
varying float v_alpha;
#if defined(BASE_MAP)
uniform sampler2D base_map;
#endif
#endif
#if defined(PACKED_DEPTH)
varying float v_depth;
#endif

void main() {
#if defined(ALPHA_TEST)
  float alpha = base_colour.a * v_alpha;
#if defined(BASE_MAP)
  alpha *= texture2D(base_map, BASE_MAP).a;
#endif
  if (alpha < alpha_cutoff) discard;
#endif
#if defined(PACKED_DEPTH)
  vec4 digits = fract(v_depth * vec4(1.0, 255.0, 65025.0, 16581375.0));
  gl_FragColor = digits - digits.yzww * vec4(1.0 / 255.0, 1.0 / 255.0, 1.0 / 255.0, 0.0);
#else
  gl_FragColor = vec4(1.0);
#endif
}
