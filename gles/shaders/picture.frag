// The camera's picture; where the layer covers it (COVERED) or part of it (EDGE), Linf N over it in linear light.
varying vec2 v_picture;
#if defined(COVERED) || defined(EDGE)
uniform sampler2D layer;
uniform float layer_unit;
varying vec2 v_layer;
varying vec3 v_airlight;
#endif

void main() {
#if defined(COVERED)
  vec4 object = texture2D(layer, v_layer);
#if defined(LAYER_IN_8_BITS)
  object.rgb *= object.rgb * layer_unit;
#endif
  gl_FragColor = vec4(encoded(v_airlight * object.rgb) + dither(), 1.0);
#elif defined(EDGE)
  vec3 behind = camera_at(v_picture);
  vec4 object = texture2D(layer, v_layer);
#if defined(LAYER_IN_8_BITS)
  object.rgb *= object.rgb * layer_unit;
#endif
  vec3 light = light_of(clamp(behind, 0.0, 1.0)) * (1.0 - object.a) + v_airlight * object.rgb;
  gl_FragColor = vec4(object.a > 0.0 ? encoded(light) + dither() : behind, 1.0);
#else
  gl_FragColor = vec4(camera_at(v_picture), 1.0);
#endif
}
