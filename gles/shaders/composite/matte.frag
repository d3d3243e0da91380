// The weighted mean of a node's pixels, as the square root of linear light; alpha 0: there are none.
precision highp sampler2D;
#include "dither.glsl"
#include "response.glsl"
#include "camera_picture.glsl"

varying vec4 v_taps_0;
varying vec4 v_taps_1;
varying vec4 v_taps_2;
varying vec4 v_taps_3;
varying vec4 v_weights_0;
varying vec4 v_weights_1;

vec3 light_at(vec2 place) { return light_of(clamp(camera_at(clamp(place, 0.0, 1.0)), 0.0, 1.0)); }

void main() {
  vec3 sum = v_weights_0.x * light_at(v_taps_0.xy) + v_weights_0.y * light_at(v_taps_0.zw) +
             v_weights_0.z * light_at(v_taps_1.xy) + v_weights_0.w * light_at(v_taps_1.zw) +
             v_weights_1.x * light_at(v_taps_2.xy) + v_weights_1.y * light_at(v_taps_2.zw) +
             v_weights_1.z * light_at(v_taps_3.xy) + v_weights_1.w * light_at(v_taps_3.zw);
  float weight = dot(v_weights_0 + v_weights_1, vec4(1.0));
  gl_FragColor = weight > 0.0 ? vec4(sqrt(sum / weight) + dither(gl_FragCoord.xy) / 255.0, 1.0) : vec4(0.0);
}
