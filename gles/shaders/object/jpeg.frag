// JPEG's way of losing detail (ITU-T T.81 A.3.3, A.3.4), in separate passes along rows and columns of 8 x 8 blocks: the
// cosine transform, its coefficients rounded to the stream's steps, the inverse. Two values a texel, 16 bits each.
//   FORWARD or INVERSE: along `along`; FORWARD reads the picture with FROM_LUMA, FROM_CHROMA; rounds with ROUNDED.
//   neither: luma and chroma as a picture.
#include "packed.glsl"

const float kPi = 3.14159265;
const float kReach = 8.25;                 // coefficients of samples of -128 .. 127 levels lie within half of it
const float kMiddle = 128.0 / 255.0;       // what the standard shifts samples by
// Encoder and decoder keep 8 bits, and even areas often lie half-way between two: .03 is more than 16 bits lose.
vec2 in_levels(vec2 value) { return floor(value * 255.0 + 0.53) / 255.0; }
const float kZero = 32768.0 / 65535.0;      // exact in 16 bits: most coefficients are 0, and their errors would add up
vec2 values_of(vec4 texel) { return (from_bytes(texel) - kZero) * kReach; }

uniform highp sampler2D values;  // the picture, coefficients, or luma
uniform vec2 texel;              // of `values`

#if defined(FORWARD) || defined(INVERSE)
uniform vec2 along;
uniform vec2 shared_pixels;  // pixels for a value, across and down
uniform vec2 last_place;     // of the picture's last pixel: the encoder repeats it

vec2 value_at(vec2 pixel) {
#if defined(FROM_LUMA)
  float y = dot(texture2D(values, min(pixel * texel, last_place)).rgb, vec3(0.299, 0.587, 0.114));
  return in_levels(vec2(y, 0.0)) - vec2(kMiddle, 0.0);
#elif defined(FROM_CHROMA)
  vec3 rgb = texture2D(values, min(pixel * shared_pixels * texel, last_place)).rgb;
  return in_levels(vec2(dot(rgb, vec3(-0.168736, -0.331264, 0.5)), dot(rgb, vec3(0.5, -0.418688, -0.081312))));
#else
  return values_of(texture2D(values, pixel * texel));
#endif
}
#endif

#if defined(ROUNDED)
uniform sampler2D steps;  // 16 x 8: of luma, of chroma
uniform float first_step; // column
vec2 rounded(vec2 coefficient) {
  vec2 at = vec2(mod(floor(gl_FragCoord.x), 8.0) + first_step, mod(floor(gl_FragCoord.y), 8.0));
  float size = max(texture2D(steps, (at + 0.5) / vec2(16.0, 8.0)).r, 1.0 / 255.0);
  return sign(coefficient) * floor(abs(coefficient) / size + 0.5005) * size;
}
#endif

#if defined(FORWARD)
// Cosines of equal steps follow from the two before.
void main() {
  vec2 here = floor(gl_FragCoord.xy);
  float order = mod(dot(here, along), 8.0);
  vec2 first = here - order * along + 0.5;
  float angle = order * kPi / 16.0;
  float before = cos(angle), now = before, turn = 2.0 * cos(2.0 * angle);
  vec2 sum = vec2(0.0);
  for (int i = 0; i < 8; ++i) {
    sum += now * value_at(first + float(i) * along);
    float next = turn * now - before;
    before = now;
    now = next;
  }
  sum *= order < 0.5 ? 0.35355339 : 0.5;
#if defined(ROUNDED)
  sum = rounded(sum);
#endif
  gl_FragColor = in_bytes(sum / kReach + kZero);
}
#elif defined(INVERSE)
void main() {
  vec2 here = floor(gl_FragCoord.xy);
  float place = mod(dot(here, along), 8.0);
  vec2 first = here - place * along + 0.5;
  float before = 1.0, now = cos((2.0 * place + 1.0) * kPi / 16.0), turn = 2.0 * now;
  vec2 sum = 0.70710678 * value_at(first);
  for (int i = 1; i < 8; ++i) {
    sum += now * value_at(first + float(i) * along);
    float next = turn * now - before;
    before = now;
    now = next;
  }
  gl_FragColor = in_bytes(0.5 * sum / kReach + kZero);
}
#else
uniform highp sampler2D chroma;
void main() {
  vec2 place = gl_FragCoord.xy * texel;
  float y = clamp(in_levels(values_of(texture2D(values, place))).x + kMiddle, 0.0, 1.0);
  vec2 c = in_levels(values_of(texture2D(chroma, place)));
  gl_FragColor = vec4(y + 1.402 * c.y, y - 0.344136 * c.x - 0.714136 * c.y, y + 1.772 * c.x, 1.0);
}
#endif
