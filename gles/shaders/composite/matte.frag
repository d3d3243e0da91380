// A node of the matte: the weighted mean of the pixels that are nearest to it in eight directions, as the square root of
// linear light; alpha 0: there are none.
precision highp sampler2D;
#include "dither.glsl"
#include "response.glsl"
#include "camera_picture.glsl"

uniform sampler2D taps;     // (matte.cpp): texels of four directions, with one more than the steps that way; 0: none
uniform vec2 taps_step;     // one texel
uniform float columns;      // of nodes; as many to the right of them are of what is in front
uniform vec2 corner_px;     // of the first node's cell
uniform float cell_px;
uniform vec2 picture_size;

// The sum of two opposite directions' pixels, and of their weights: what is behind changes from place to place, leaves
// from one to the next.
vec4 along(vec2 direction, float there, float back, vec2 from, vec2 middle, bool front) {
  vec2 steps = floor(vec2(there, back) * 255.0 + 0.5);
  vec2 one = from + (steps.x - 1.0) * direction, other = from - (steps.y - 1.0) * direction;
  vec2 weight = min(steps, 1.0) / (vec2(distance(one, middle), distance(other, middle)) + 1.0);
  if (!front) weight *= weight;
  vec2 step = 1.0 / picture_size;
  vec3 first = light_of(clamp(camera_at(clamp((one + 0.5) * step, 0.0, 1.0)), 0.0, 1.0));
  vec3 second = light_of(clamp(camera_at(clamp((other + 0.5) * step, 0.0, 1.0)), 0.0, 1.0));
  return vec4(weight.x * first + weight.y * second, weight.x + weight.y);
}

void main() {
  vec2 texel = floor(gl_FragCoord.xy);
  vec2 place = vec2(gl_FragCoord.x, 2.0 * texel.y + 0.5) * taps_step;
  vec4 first = texture2D(taps, place), second = texture2D(taps, place + vec2(0.0, taps_step.y));
  gl_FragColor = vec4(0.0);
  if (dot(first + second, vec4(1.0)) > 0.0) {
    bool front = texel.x >= columns;
    vec2 middle = corner_px + cell_px * vec2(front ? texel.x - columns : texel.x, texel.y) + 0.5 * cell_px;
    vec2 from = clamp(middle, vec2(0.0), picture_size - 1.0);
    middle -= 0.5;
    vec4 sum = along(vec2(1.0, 0.0), first.r, second.r, from, middle, front) +
               along(vec2(1.0, 1.0), first.g, second.g, from, middle, front) +
               along(vec2(0.0, 1.0), first.b, second.b, from, middle, front) +
               along(vec2(-1.0, 1.0), first.a, second.a, from, middle, front);
    gl_FragColor = vec4(sqrt(sum.rgb / sum.a) + dither(gl_FragCoord.xy) / 255.0, 1.0);
  }
}
