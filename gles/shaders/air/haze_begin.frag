// The picture's attenuated light before the blur (H Eq 2; for channels with different extinction see haze_picture.hpp).
#include "packed.glsl"

uniform highp sampler2D red_green;  // linear light / light_unit
uniform highp sampler2D blue;
uniform highp sampler2D along_row;  // range; the other channel is not used here
uniform vec2 texel;
uniform float range_scale;
uniform vec3 weight[2];
uniform vec3 extinction[2];
uniform vec3 airlight;
uniform float light_unit;
uniform float unit;  // full scale when written in bytes

void main() {
  vec2 place = gl_FragCoord.xy * texel;
  vec3 light = light_unit * vec3(from_bytes(texture2D(red_green, place)), from_bytes(texture2D(blue, place)).x);
  float range = range_scale * from_bytes(texture2D(along_row, place)).x;
  vec3 left = weight[0] * exp(-extinction[0] * range) + weight[1] * exp(-extinction[1] * range);
  float most = max(max(left.r, left.g), left.b);
  vec4 faded = vec4(left * light + (most - left) * airlight, most);
#if defined(FIRST_PAIR)
  gl_FragColor = in_bytes(faded.rg / unit);
#elif defined(SECOND_PAIR)
  gl_FragColor = in_bytes(faded.ba / unit);
#else
  gl_FragColor = in_halves(faded);
#endif
}
