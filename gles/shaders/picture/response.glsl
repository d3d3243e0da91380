// Converts between the camera's encoded values and linear light, both 0..1. Encoding starts from the light's square
// root, which the layer stores.
#if defined(RESPONSE_SRGB)
// IEC 61966-2-1 with minimax polynomials instead of pow: errors of .009/255 in encoding and .005/255 of light in
// decoding. Five times as fast as pow.
const float kSlope = 12.92;
const float kLinearEnd = 0.04045;          // encoded
const float kRootOfLinearEnd = 0.0559535;  // of its light
vec3 encoded_root(vec3 root) {
  vec3 s = min(root, 1.0);
  vec3 r = sqrt(s);
  vec3 power = -0.06461152 + r * (0.19613576 + r * (1.12268187 + r * (-0.33550179 + r * 0.08133006)));
  return mix(kSlope * s * s, power, step(kRootOfLinearEnd, s));
}
vec3 light_of(vec3 code) {
  vec3 power =
      0.00101054 + code * (0.03015452 + code * (0.5388562 + code * (0.61139626 + code * (-0.24117983 + code * 0.05978329))));
  return mix(code / kSlope, power, step(kLinearEnd, code));
}
#elif defined(RESPONSE_TABLE)
// Each texel holds an entry and its successor as 16-bit numbers in two channels each; rows 0-2: light of code, rows
// 4-6: code of the square root of light.
#if defined(GL_ES)
uniform sampler2D response_table;
uniform float response_entries;  // = width of the texture
float in_table(float at, float row) {
  float place = clamp(at, 0.0, 1.0) * (response_entries - 1.0);
  float entry = min(floor(place), response_entries - 2.0);
  vec4 texel = texture2D(response_table, vec2((entry + 0.5) / response_entries, (row + 0.5) / 8.0));
  // Constants as decimals: 65535 is infinite in 16 bits.
  vec2 ends = texel.xz * 0.996108949 + texel.yw * 0.003891051;
  return mix(ends.x, ends.y, place - entry);
}
#endif
vec3 encoded_root(vec3 root) { return vec3(in_table(root.r, 4.0), in_table(root.g, 5.0), in_table(root.b, 6.0)); }
vec3 light_of(vec3 code) { return vec3(in_table(code.r, 0.0), in_table(code.g, 1.0), in_table(code.b, 2.0)); }
#else
vec3 encoded_root(vec3 root) { return min(root * root, 1.0); }
vec3 light_of(vec3 code) { return code; }
#endif
vec3 encoded(vec3 light) { return encoded_root(sqrt(max(light, 0.0))); }
