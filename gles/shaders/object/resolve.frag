// Resolves the rotated lattice of samples to pixels: the mean of the 17 samples in each pixel (object_layer.cpp; MEANS:
// found before, mean.frag), with chroma at the camera's resolution and what the foreground covers wholly left out.
#include "dither.glsl"
#include "layer.glsl"

#if defined(MEANS)
uniform sampler2D means;
varying vec2 v_mean;              // texture coordinates of the pixel's mean
uniform float mean_step;          // one texel
#else
uniform sampler2D samples;
varying vec2 v_centre;            // texture coordinates of the pixel's central sample
uniform vec2 sample_step;         // one texel
uniform vec2 offsets[17];
#endif
uniform vec2 first_pixel;         // the picture's pixel at gl_FragCoord 0.5
#if defined(FOREGROUND)
uniform sampler2D foreground;
varying vec2 v_picture;
#endif

// Of the pixel at that offset.
#if defined(MEANS)
vec4 mean_at(vec2 to) { return texture2D(means, v_mean + to * mean_step); }
#else
vec4 mean_at(vec2 to) {
  vec2 centre = v_centre + vec2(4.0 * to.x + to.y, 4.0 * to.y - to.x) * sample_step;
  vec4 sum = vec4(0.0);
  for (int i = 0; i < 17; ++i) sum += texture2D(samples, centre + offsets[i] * sample_step);
  return sum / 17.0;
}
#endif

#if defined(CHROMA_COLUMNS)
const vec3 kLuma = vec3(0.299, 0.587, 0.114);  // Rec. 601, as the camera used for its chroma
vec3 grey_of(vec3 light) { return vec3(dot(light, kLuma)); }

// The pixels of a block share the object's own chroma, weighted by coverage: each pixel keeps its luma, and pixels
// without the object do not change.
vec4 with_shared_chroma(vec4 mean) {
  vec2 pixel = floor(gl_FragCoord.xy) + first_pixel;
  vec2 to_first = -mod(pixel, vec2(float(CHROMA_COLUMNS), float(CHROMA_ROWS)));
  vec4 sum = vec4(0.0);
  for (int y = 0; y < CHROMA_ROWS; ++y)
    for (int x = 0; x < CHROMA_COLUMNS; ++x) sum += mean_at(to_first + vec2(float(x), float(y)));
  vec3 difference = (sum.rgb - grey_of(sum.rgb)) / max(sum.a, 0.0001);
  return vec4(max(grey_of(mean.rgb) + mean.a * difference, 0.0), mean.a);
}
#endif

void main() {
  vec4 mean = mean_at(vec2(0.0));
#if defined(CHROMA_COLUMNS)
  mean = with_shared_chroma(mean);
#endif
#if defined(FOREGROUND)
  // Where it covers a part of the pixel, picture.frag finds out which (matte.glsl).
  mean *= sign(texture2D(foreground, v_picture).r);
#endif
  vec2 pixel = gl_FragCoord.xy + first_pixel;
  vec3 root = sqrt(mean.rgb);
  // The layer's own quantisation is dithered too, by an uncorrelated pattern (interleaved gradient noise, Jimenez
  // 2014), because the errors of two correlated dithers would add up.
  float steps = (fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715)))) - 0.5) * step(0.0005, mean.a);
#if defined(LAYER_IN_8_BITS)
  root += steps / 255.0;
#else
  // Rounds to a half float's 11 bits, because some drivers truncate; the last factor keeps them from truncating
  // further.
  vec3 half_step = exp2(floor(log2(max(root, 0.0001))) - 10.0);
  root = floor(root / half_step + steps + 0.5) * half_step * 1.000001;
#endif
  gl_FragColor = vec4(root, stored_alpha(mean.a, dither(pixel)));
}
