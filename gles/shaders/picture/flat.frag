uniform sampler2D picture;  // premultiplied
uniform float opacity;
varying vec2 v_place;

void main() { gl_FragColor = texture2D(picture, v_place) * opacity; }
