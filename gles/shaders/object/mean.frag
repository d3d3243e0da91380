// The means of the pixels' 17 samples, spread along the lattice's columns on the way: along its rows they are already.
// A pixel needs the sums of five columns only, which takes a third of what spreading every sample does.
//   COARSE_STEP: every so many samples each way are kept, which hold a part of the spread (coarse_spread.cpp).
uniform sampler2D samples;
varying vec2 v_centre;     // texture coordinates of the pixel's central sample
uniform vec2 sample_step;  // one texel

#if defined(COARSE_STEP)
uniform float lattice_size;     // samples across the buffer that v_centre is of
uniform vec4 weights[COUNT];    // for each place between two kept samples

void main() {
  vec2 centre = floor(v_centre * lattice_size);
  vec2 before = floor((centre + 0.5) / float(COARSE_STEP));
  vec2 phase = centre - float(COARSE_STEP) * before;
  const vec4 phases = vec4(0.0, 1.0, 2.0, 3.0);
  vec4 across = vec4(equal(vec4(phase.x), phases)), down = vec4(equal(vec4(phase.y), phases));
  vec2 first = before - float(BEFORE) + 0.5;
  vec4 sum = vec4(0.0);
  for (int j = 0; j < COUNT; ++j) {
    vec4 row = vec4(0.0);
    for (int i = 0; i < COUNT; ++i)
      row += dot(weights[i], across) * texture2D(samples, (first + vec2(float(i), float(j))) * sample_step);
    sum += dot(weights[j], down) * row;
  }
  gl_FragColor = sum * 1.00001;
}
#else
uniform vec4 weights[2 * SPREAD_RADIUS + 5];  // by rows, of the middle column and the next two; before it, mirrored

void main() {
  vec2 next = vec2(sample_step.x, 0.0);
  vec4 sum = vec4(0.0);
  for (int i = 0; i <= 2 * SPREAD_RADIUS + 4; ++i) {
    vec2 middle = v_centre + vec2(0.0, float(i - SPREAD_RADIUS - 2) * sample_step.y);
    vec3 after = weights[i].xyz, before = weights[2 * SPREAD_RADIUS + 4 - i].xyz;
    sum += after.x * texture2D(samples, middle) + after.y * texture2D(samples, middle + next) +
           after.z * texture2D(samples, middle + 2.0 * next) + before.y * texture2D(samples, middle - next) +
           before.z * texture2D(samples, middle - 2.0 * next);
  }
  // Slightly above 1, so that full coverage survives drivers that truncate half floats.
  gl_FragColor = sum * 1.00001;
}
#endif
