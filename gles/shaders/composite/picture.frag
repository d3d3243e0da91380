// The camera's picture, with Linf N over it in linear light where the layer covers it fully (COVERED) or partly (EDGE).
// PROCESSED: as the camera's processing left it (camera_processing.cpp). COVERAGE: the object's share of each pixel in
// alpha, 0 only where it changes nothing. PLANE: only what is to be laid over the camera's picture by the display.
// Edges are also compiled as C++ (mixed_edges.cpp), which has pictures and tables of its own.
#if defined(MATTE_NODES) && defined(GL_ES)
precision highp sampler2D;  // small differences of the picture's values are solved for
#endif
#include "dither.glsl"
#include "layer.glsl"
#include "response.glsl"
#if defined(GL_ES)
#include "camera_picture.glsl"
#endif
#include "matte.glsl"
#include "noise.glsl"
#include "saturation.glsl"
#include "plane.glsl"

#if !defined(COVERED)
varying vec2 v_picture;
#endif
#if defined(COVERED) || defined(EDGE)
uniform sampler2D layer;
varying vec2 v_layer;
varying vec3 v_airlight_root;
#if defined(PROCESSED)
uniform sampler2D processed;
varying vec2 v_processed;
#endif
#endif
#if defined(EDGE)
varying vec2 v_pixel;
#endif

#if defined(IN_FRONT)
uniform sampler2D in_front;   // rgb: what is behind passers before the object; a: the pixel's free share
uniform vec4 in_front_place;  // the picture's 0..1 to the texture's: scale, offset
#endif
#if defined(MATTE) || defined(IN_FRONT)
const float kLeastCoverage = 0.0005;  // below it the camera's picture passes unchanged
#endif

void main() {
#if defined(COVERED) && defined(PROCESSED)
  gl_FragColor = vec4(texture2D(processed, v_processed).rgb, 1.0);
#elif defined(COVERED)
  vec4 object = texture2D(layer, v_layer);
  vec3 root = v_airlight_root * object.rgb;
#if defined(SATURATED)
  root = sqrt(saturated(root * root));
#endif
#if defined(NOISE)
  root = sqrt(noisy(root * root, 1.0));
#endif
  gl_FragColor = vec4(encoded_root(root) + dither_in(object.a) / 255.0, 1.0);
#elif defined(EDGE) && defined(PROCESSED) && !defined(PLANE)
  vec4 seen = texture2D(processed, v_processed);  // alpha 0: the object changes nothing here
  gl_FragColor = vec4(seen.a > 0.0 ? seen.rgb : camera_at(v_picture), 1.0);
#elif defined(EDGE)
  vec3 behind = camera_at(v_picture);
  vec4 object = texture2D(layer, v_layer);
  float coverage = coverage_in(object.a);
  vec3 root = v_airlight_root * object.rgb;
  vec3 own = root * root;
#if defined(SATURATED)
  own = saturated(own);
#endif
  vec3 light = light_of(clamp(behind, 0.0, 1.0));
#if defined(MATTE) || defined(IN_FRONT)
#if defined(MATTE)
  Matte matte = matte_at(v_picture, light);
  float open_share = matte.open_share;
  vec3 open_behind = matte.behind;  // open_share times the light behind
#else
  float open_share = 1.0;
  vec3 open_behind = light;
#endif
#if defined(IN_FRONT)
  vec4 passer = texture2D(in_front, v_picture * in_front_place.xy + in_front_place.zw);
  bool is_hidden = passer.a < 1.0;
  if (ANY(is_hidden)) {
    open_share *= passer.a;
    open_behind = EITHER(is_hidden, open_share * light_of(passer.rgb), open_behind);
  }
#endif
  own *= open_share;
  light = max(light + own - coverage * open_behind, 0.0);
  coverage *= open_share;
  bool changes = coverage > kLeastCoverage;
#else
  light = light * (1.0 - coverage) + own;
  bool changes = object.a > 0.0;
#endif
// `shown` is written where it is used: drivers then round open pixels and a plane's opaque ones as the picture's.
#if defined(PROCESSED)
#define shown texture2D(processed, v_processed).rgb
#else
#if defined(NOISE)
  light = noisy(light, coverage);
#endif
#define shown (encoded(light) + dither(v_pixel) / 255.0)
#endif
#if defined(PLANE)
  gl_FragColor = changes ? for_plane(behind, shown, own, coverage) : vec4(0.0);
#elif defined(COVERAGE)
  gl_FragColor = vec4(EITHER(changes, shown, behind), EITHER(changes, max(coverage, 1.0 / 255.0), 0.0));
#else
  gl_FragColor = vec4(changes ? shown : behind, 1.0);
#endif
#elif defined(COVERAGE)
  gl_FragColor = vec4(camera_at(v_picture), 0.0);
#else
  gl_FragColor = vec4(camera_at(v_picture), 1.0);
#endif
}
