// A Gaussian over the lattice of samples, along its rows or its columns; for every few samples where those hold it.
#include "dither.glsl"

uniform sampler2D samples;
uniform vec2 sample_step;   // one texel
uniform vec2 stride;        // texels from one result to the next
uniform vec2 along;         // one texel in the pass's direction
uniform float weights[SPREAD_RADIUS + 1];

void main() {
  vec2 place = (floor(gl_FragCoord.xy) * stride + 0.5) * sample_step;
  vec4 sum = weights[0] * texture2D(samples, place);
  for (int i = 1; i <= SPREAD_RADIUS; ++i)
    sum += weights[i] * (texture2D(samples, place + float(i) * along) + texture2D(samples, place - float(i) * along));
#if defined(LAYER_IN_8_BITS)
  sum.rgb += dither(gl_FragCoord.xy) / 255.0;
#endif
  // Slightly above 1, so that full coverage survives drivers that truncate half floats.
  gl_FragColor = sum * 1.00001;
}
