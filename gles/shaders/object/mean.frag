// The means of the pixels' 17 samples, spread along the lattice's columns on the way: along its rows they are already.
// A pixel needs the sums of five columns only, which takes a third of what spreading every sample does.
uniform sampler2D samples;
varying vec2 v_centre;     // texture coordinates of the pixel's central sample
uniform vec2 sample_step;  // one texel
uniform vec3 weights[2 * SPREAD_RADIUS + 5];  // by rows, of the middle column and the next two; before it, mirrored

void main() {
  vec2 next = vec2(sample_step.x, 0.0);
  vec4 sum = vec4(0.0);
  for (int i = 0; i <= 2 * SPREAD_RADIUS + 4; ++i) {
    vec2 middle = v_centre + vec2(0.0, float(i - SPREAD_RADIUS - 2) * sample_step.y);
    vec3 after = weights[i], before = weights[2 * SPREAD_RADIUS + 4 - i];
    sum += after.x * texture2D(samples, middle) + after.y * texture2D(samples, middle + next) +
           after.z * texture2D(samples, middle + 2.0 * next) + before.y * texture2D(samples, middle - next) +
           before.z * texture2D(samples, middle - 2.0 * next);
  }
  // Slightly above 1, so that full coverage survives drivers that truncate half floats.
  gl_FragColor = sum * 1.00001;
}
