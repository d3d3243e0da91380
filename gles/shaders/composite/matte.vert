// A node of the matte: one point of its texture, from up to eight pixels of the camera's picture.
attribute vec4 position;  // the texel in clip coordinates; the node's middle in pixels
attribute vec4 taps_0;    // two pixels each; negative: none
attribute vec4 taps_1;
attribute vec4 taps_2;
attribute vec4 taps_3;
uniform vec2 picture_size;
uniform float falloff;  // a pixel's weight is its distance to this power
varying vec4 v_taps_0;
varying vec4 v_taps_1;
varying vec4 v_taps_2;
varying vec4 v_taps_3;
varying vec4 v_weights_0;
varying vec4 v_weights_1;

float weight(vec2 tap) { return tap.x < 0.0 ? 0.0 : pow(distance(tap, position.zw) + 1.0, falloff); }

void main() {
  v_taps_0 = (taps_0 + 0.5) / picture_size.xyxy;
  v_taps_1 = (taps_1 + 0.5) / picture_size.xyxy;
  v_taps_2 = (taps_2 + 0.5) / picture_size.xyxy;
  v_taps_3 = (taps_3 + 0.5) / picture_size.xyxy;
  v_weights_0 = vec4(weight(taps_0.xy), weight(taps_0.zw), weight(taps_1.xy), weight(taps_1.zw));
  v_weights_1 = vec4(weight(taps_2.xy), weight(taps_2.zw), weight(taps_3.xy), weight(taps_3.zw));
  gl_PointSize = 1.0;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}
