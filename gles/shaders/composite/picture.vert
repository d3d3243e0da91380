// Rectangles of the camera's picture, at far depth.
#include "airlight.glsl"

attribute vec2 position;  // pixels from the picture's top left corner
uniform vec2 picture_size;
uniform mat3 pixel_to_clip;
#if !defined(COVERED)
varying vec2 v_picture;
#endif
#if defined(COVERED) || defined(EDGE)
uniform vec4 layer_place;  // left, top, 1 / width, 1 / height
uniform float layer_unit;
uniform vec3 measured_light[AIRLIGHT_COLUMNS * AIRLIGHT_ROWS];
uniform vec4 measured_place;
#if defined(NOISE)
uniform vec3 noise_place;  // where this frame's pattern begins, in its texels; 1 / its size
varying vec2 v_noise;
#endif
varying vec2 v_layer;
varying vec3 v_airlight_root;  // square root, of the layer's unit
#if defined(PROCESSED)
uniform vec4 processed_place;  // left, top, 1 / width, 1 / height
varying vec2 v_processed;
#endif
#endif
#if defined(EDGE)
varying vec2 v_pixel;
#endif

void main() {
  vec2 pixel = position - 0.5;
#if !defined(COVERED)
  v_picture = position / picture_size;
#endif
#if defined(COVERED) || defined(EDGE)
  v_layer = (position - layer_place.xy) * layer_place.zw;
#if defined(PROCESSED)
  v_processed = (position - processed_place.xy) * processed_place.zw;
#endif
#if defined(NOISE)
  v_noise = (position + noise_place.xy) * noise_place.z;
#endif
  v_airlight_root = sqrt(airlight_on(measured_light, measured_place, pixel) * layer_unit);
#endif
#if defined(EDGE)
  v_pixel = position;
#endif
  gl_Position = vec4((pixel_to_clip * vec3(pixel, 1.0)).xy, 1.0, 1.0);
}
