// The real scene's planar depth, and the test for being hidden by it.
#if defined(SCENE_DEPTH)
uniform sampler2D scene_depth;   // centimetres in three bytes; the largest value means unknown
uniform vec2 scene_size;         // pixels
uniform mat3 fragment_to_pixel;  // (0, 0) is the centre of the top left one

float nearer(vec2 pixel, float depth_m) {
  vec3 bytes = floor(texture2D(scene_depth, (pixel + 0.5) / scene_size).rgb * 255.0 + 0.5);
  return step(dot(bytes, vec3(655.36, 2.56, 0.01)), depth_m);
}

// Averaging the depths of a near and a far surface is meaningless, so the comparison is interpolated instead: a
// fragment is hidden where the weight of nearer surfaces reaches one half, which puts edges between pixel centres.
bool is_hidden(float depth_m) {
  vec2 at = (fragment_to_pixel * vec3(gl_FragCoord.xy, 1.0)).xy;
  vec2 first = floor(at), along = at - first;
  float above = mix(nearer(first, depth_m), nearer(first + vec2(1.0, 0.0), depth_m), along.x);
  float below = mix(nearer(first + vec2(0.0, 1.0), depth_m), nearer(first + vec2(1.0, 1.0), depth_m), along.x);
  return mix(above, below, along.y) >= 0.5;
}
#endif
