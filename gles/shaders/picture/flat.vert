attribute vec2 position;   // 0..1 across the picture, from its top left corner
uniform vec4 place;        // left, top, width, height in clip units
varying vec2 v_place;

void main() {
  v_place = position;
  gl_Position = vec4(place.xy + position * place.zw, 0.0, 1.0);
}
