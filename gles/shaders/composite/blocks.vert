// Some blocks of a part of the picture, whose size in pixels is `part`, at whatever resolution.
attribute vec2 position;  // pixels from the part's corner
uniform vec2 part;
void main() { gl_Position = vec4(2.0 * position / part - 1.0, 0.0, 1.0); }
