// The surroundings without the sun's disc: eight squares side by side (radiance_atlas.hpp).
uniform sampler2D sky_atlas;
uniform vec2 sky_unit;  // full scale of the reflections' squares; of the last square

const float kSquare = 65.0;  // texels along a side of a square: 32 on either side of the middle one
const vec2 kAtlas = vec2(8.0 * kSquare, kSquare);
const float kTableSteps = 31.0;  // steps of the first square's table along each side

// Octahedral map coordinates, -1 .. 1.
vec2 on_map(vec3 towards) {
  vec3 d = towards / (abs(towards.x) + abs(towards.y) + abs(towards.z));
  vec2 over = 1.0 - abs(d.yx);
  return d.z >= 0.0 ? d.xy : vec2(d.x >= 0.0 ? over.x : -over.x, d.y >= 0.0 ? over.y : -over.y);
}
vec3 in_square(float square, vec2 place) {
  vec2 texels = vec2(kSquare * square + 0.5 * kSquare, 0.5 * kSquare) + 0.5 * (kSquare - 1.0) * place;
  vec4 texel = texture2D(sky_atlas, texels / kAtlas);
  vec3 root = texel.rgb * texel.a;
  return (square < 6.5 ? sky_unit.x : sky_unit.y) * root * root;
}

// Irradiance / pi on a surface of normal n.
vec3 from_sky(vec3 n) { return in_square(7.0, on_map(n)); }

#if defined(REFLECTS)
// The radiance reflected by a mirror of this roughness.
vec3 mirrored_sky(vec3 image, float roughness) {
  float level = 6.0 * clamp(roughness, 0.0, 1.0), sharper = min(floor(level), 5.0);
  vec2 place = on_map(image);
  return mix(in_square(1.0 + sharper, place), in_square(2.0 + sharper, place), level - sharper);
}

// Single reflection of uniform light: by a white mirror, and the Fresnel edge's part of it. For sampling the sky: how
// far the direction leans from the normal to the mirror direction, and the roughness of the blur.
vec4 given_back(float across, float roughness) {
  return texture2D(sky_atlas, (vec2(sqrt(across), roughness) * kTableSteps + 0.5) / kAtlas);
}
#endif
