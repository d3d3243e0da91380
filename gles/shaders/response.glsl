// Between the camera's encoded values and linear light, both 0..1.
#if defined(RESPONSE_SRGB)
// IEC 61966-2-1
vec3 encoded(vec3 light) {
  vec3 l = clamp(light, 0.0, 1.0);
  return mix(12.92 * l, 1.055 * pow(l, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, l));
}
vec3 light_of(vec3 code) {
  return mix(code / 12.92, pow((code + 0.055) / 1.055, vec3(2.4)), step(0.04045, code));
}
#elif defined(RESPONSE_TABLE)
// Each texel holds an entry and its successor as 16-bit numbers in two channels each; rows 0-2: light of code, rows
// 4-6: code of the square root of light.
uniform sampler2D response_table;
uniform float response_entries;  // = width of the texture
float in_table(float at, float row) {
  float place = clamp(at, 0.0, 1.0) * (response_entries - 1.0);
  float entry = min(floor(place), response_entries - 2.0);
  vec4 texel = texture2D(response_table, vec2((entry + 0.5) / response_entries, (row + 0.5) / 8.0));
  vec2 ends = (texel.xz * 65280.0 + texel.yw * 255.0) / 65535.0;
  return mix(ends.x, ends.y, place - entry);
}
vec3 encoded(vec3 light) {
  vec3 root = sqrt(clamp(light, 0.0, 1.0));
  return vec3(in_table(root.r, 4.0), in_table(root.g, 5.0), in_table(root.b, 6.0));
}
vec3 light_of(vec3 code) { return vec3(in_table(code.r, 0.0), in_table(code.g, 1.0), in_table(code.b, 2.0)); }
#else
vec3 encoded(vec3 light) { return clamp(light, 0.0, 1.0); }
vec3 light_of(vec3 code) { return code; }
#endif
