// One pass of diffusion (H Eq 11; estimator/haze/diffusion.hpp is the reference): light flows between each pixel and
// four others, whole pixels away.
#include "packed.glsl"

uniform highp sampler2D light;        // IN_PAIRS: two of its channels in bytes
uniform highp sampler2D along_row;    // range; sum of its steps along the row, in turns
uniform highp sampler2D down_column;  // range; sum of its steps down the column
uniform vec2 texel;             // one pixel
uniform float offset;           // pixels
uniform float range_scale;
uniform float inner;            // the picture's own width, and what is added to it at range 1
uniform float widening;
uniform vec2 variance;          // of the passes before, and of this one
uniform float per_variance;     // diffusion rate per variance
uniform vec2 surfaces;          // differences of the steps' sums: below the first one surface, above the second two

#if defined(IN_PAIRS)
#define LIGHT vec2
LIGHT light_at(vec2 place) { return from_bytes(texture2D(light, place)); }
#else
#define LIGHT vec4
LIGHT light_at(vec2 place) { return texture2D(light, place); }
#endif

// Converts range and sum of steps to rate and sum.
vec2 rate_of(vec2 place_on_surface) {
  float range = range_scale * place_on_surface.x;
  float sigma = inner + widening * range * sqrt(range);
  float wanted = sigma * sigma - inner * inner;
#if defined(MEAN_RATES)
  return vec2(wanted * per_variance, 0.0);
#else
  return vec2(clamp(wanted - variance.x, 0.0, variance.y) * per_variance, place_on_surface.y);
#endif
}

float conductance(vec2 one, vec2 other) {
#if defined(MEAN_RATES)
  return 0.5 * (one.x + other.x);
#else
  float apart = abs(one.y - other.y);
  apart = min(apart, 1.0 - apart);
  return min(one.x, other.x) * smoothstep(0.0, 1.0, (surfaces.y - apart) / (surfaces.y - surfaces.x));
#endif
}

// The picture is mirrored at its edges.
vec2 mirrored(vec2 place) {
  place = abs(place);
  return 1.0 - abs(1.0 - place);
}

void main() {
  vec2 place = gl_FragCoord.xy * texel;
  vec2 right = mirrored(place + vec2(offset * texel.x, 0.0)), left = mirrored(place - vec2(offset * texel.x, 0.0));
  vec2 below = mirrored(place + vec2(0.0, offset * texel.y)), above = mirrored(place - vec2(0.0, offset * texel.y));
  vec2 in_row = rate_of(from_bytes(texture2D(along_row, place)));
  vec2 in_column = rate_of(from_bytes(texture2D(down_column, place)));
  LIGHT own = light_at(place);
  LIGHT sum = own;
  sum += conductance(in_row, rate_of(from_bytes(texture2D(along_row, right)))) * (light_at(right) - own);
  sum += conductance(in_row, rate_of(from_bytes(texture2D(along_row, left)))) * (light_at(left) - own);
  sum += conductance(in_column, rate_of(from_bytes(texture2D(down_column, below)))) * (light_at(below) - own);
  sum += conductance(in_column, rate_of(from_bytes(texture2D(down_column, above)))) * (light_at(above) - own);
#if defined(IN_PAIRS)
  gl_FragColor = in_bytes(sum);
#else
  gl_FragColor = in_halves(sum);
#endif
}
