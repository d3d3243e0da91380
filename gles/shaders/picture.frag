// The camera's picture; where the layer covers it (COVERED) or part of it (EDGE), Linf N over it in linear light.
#if !defined(COVERED)
varying vec2 v_picture;
#endif
#if defined(COVERED) || defined(EDGE)
uniform sampler2D layer;
varying vec2 v_layer;
varying vec3 v_airlight_root;
#endif
#if defined(EDGE)
varying vec2 v_pixel;
#endif

void main() {
#if defined(COVERED)
  vec4 object = texture2D(layer, v_layer);
  gl_FragColor = vec4(encoded_root(v_airlight_root * object.rgb) + dither_in(object.a) / 255.0, 1.0);
#elif defined(EDGE)
  vec3 behind = camera_at(v_picture);
  vec4 object = texture2D(layer, v_layer);
  vec3 root = v_airlight_root * object.rgb;
  vec3 light = light_of(clamp(behind, 0.0, 1.0)) * (1.0 - coverage_in(object.a)) + root * root;
  gl_FragColor = vec4(object.a > 0.0 ? encoded(light) + dither(v_pixel) / 255.0 : behind, 1.0);
#else
  gl_FragColor = vec4(camera_at(v_picture), 1.0);
#endif
}
