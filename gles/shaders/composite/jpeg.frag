// JPEG's way of losing detail (ITU-T T.81 A.3.3, A.3.4), in separate passes along rows and columns of 8 x 8 blocks: the
// cosine transform, its coefficients rounded to the stream's steps, the inverse. A texel holds two values of 16 bits: of
// luma those of two neighbours in a row, else Cb and Cr.
//   FORWARD or INVERSE: along `along`; FORWARD reads the picture with FROM_LUMA (along rows), FROM_CHROMA; rounds with
//   ROUNDED. Neither: the inverse of luma along rows, and with chroma the picture.
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
  return in_levels(vec2(y)) - kMiddle;
#elif defined(FROM_CHROMA)
  vec3 rgb = texture2D(values, min(pixel * shared_pixels * texel, last_place)).rgb;
  return in_levels(vec2(dot(rgb, vec3(-0.168736, -0.331264, 0.5)), dot(rgb, vec3(0.5, -0.418688, -0.081312))));
#else
  return values_of(texture2D(values, pixel * texel));
#endif
}
#endif

#if defined(ROUNDED)
uniform sampler2D steps;    // 16 x 8, two to a texel as values are: 4 columns of luma, from the ninth on 8 of chroma
uniform vec2 step_columns;  // the first, and how many
vec2 rounded(vec2 coefficient) {
  vec2 at = vec2(mod(floor(gl_FragCoord.x), step_columns.y) + step_columns.x, mod(floor(gl_FragCoord.y), 8.0));
  vec2 size = max(texture2D(steps, (at + 0.5) / vec2(16.0, 8.0)).ra, vec2(1.0 / 255.0));
  return sign(coefficient) * floor(abs(coefficient) / size + 0.5005) * size;
}
#endif

#if defined(FORWARD)
// Cosines of equal steps follow from the two before.
void main() {
  vec2 here = floor(gl_FragCoord.xy);
#if defined(FROM_LUMA)
  here.x *= 2.0;
#endif
  float order = mod(dot(here, along), 8.0);
  vec2 first = here - order * along + 0.5;
#if defined(FROM_LUMA)
  vec2 orders = vec2(order, order + 1.0);
#else
  vec2 orders = vec2(order);
#endif
  vec2 angle = orders * (kPi / 16.0);
  vec2 before = cos(angle), now = before, turn = 2.0 * cos(2.0 * angle);
  vec2 sum = vec2(0.0);
  for (int i = 0; i < 8; ++i) {
    sum += now * value_at(first + float(i) * along);
    vec2 next = turn * now - before;
    before = now;
    now = next;
  }
  sum *= mix(vec2(0.35355339), vec2(0.5), step(vec2(0.5), orders));
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
uniform vec2 chroma_texel;
uniform vec2 shared_pixels;
uniform sampler2D picture;  // the input: its alpha still marks the pixels that the object changes
uniform vec2 picture_texel;

// Of the pixel in its row's block: four texels of two coefficients each.
float luma_of(vec2 pixel) {
  float place = mod(pixel.x, 8.0);
  vec2 first = vec2(0.5 * (pixel.x - place), pixel.y) + 0.5;
  float turn = 2.0 * cos((2.0 * place + 1.0) * kPi / 16.0);
  vec2 wave = vec2(1.0, 0.5 * turn);
  float sum = dot(values_of(texture2D(values, first * texel)), vec2(0.70710678, wave.y));
  for (int i = 1; i < 4; ++i) {
    wave.x = turn * wave.y - wave.x;
    wave.y = turn * wave.x - wave.y;
    sum += dot(values_of(texture2D(values, (first + vec2(float(i), 0.0)) * texel)), wave);
  }
  return 0.5 * sum;
}

void main() {
  vec2 pixel = floor(gl_FragCoord.xy);
  float y = clamp(in_levels(vec2(luma_of(pixel))).x + kMiddle, 0.0, 1.0);
  vec2 c = in_levels(values_of(texture2D(chroma, (floor(pixel / shared_pixels) + 0.5) * chroma_texel)));
  float share = texture2D(picture, gl_FragCoord.xy * picture_texel).a;
  gl_FragColor = vec4(y + 1.402 * c.y, y - 0.344136 * c.x - 0.714136 * c.y, y + 1.772 * c.x, share);
}
#endif
