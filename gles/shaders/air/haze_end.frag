// The blurred light with airlight added (H Eq 4), encoded as sRGB.
#include "packed.glsl"

uniform highp sampler2D light;  // IN_PAIRS: red and green
uniform highp sampler2D light_2;  // blue and transmission
uniform vec3 airlight;
uniform float unit;
uniform vec4 box;  // where the target shows the picture: left, row 0, 1 / width, 1 / height
uniform float bottom_first;

void main() {
  vec2 place = (gl_FragCoord.xy - box.xy) * box.zw;
  if (bottom_first > 0.5) place.y = 1.0 - place.y;
#if defined(IN_PAIRS)
  vec4 faded = unit * vec4(from_bytes(texture2D(light, place)), from_bytes(texture2D(light_2, place)));
#else
  vec4 faded = texture2D(light, place);
#endif
  vec3 seen = clamp(faded.rgb + (1.0 - faded.a) * airlight, 0.0, 1.0);
  const float slope = 12.92, offset = 0.055, scale = 1.055, exponent = 2.4, linear_end = 0.0031308;  // IEC 61966-2-1
  vec3 encoded = mix(scale * pow(seen, vec3(1.0 / exponent)) - offset, slope * seen, step(seen, vec3(linear_end)));
  gl_FragColor = vec4(encoded, 1.0);
}
