// The material's values at this fragment (glTF 2.0, 3.9). A map's define names its texture coordinates' varying.
varying vec3 v_normal;
varying vec2 v_texture;
#if defined(SECOND_PLACE)
varying vec2 v_texture_2;
#endif
varying vec4 v_colour;

uniform vec4 base_colour;
#if defined(BASE_MAP)
uniform sampler2D base_map;
#endif
#if defined(ALPHA_TEST)
uniform float alpha_cutoff;
#endif
#if defined(REFLECTS)
uniform vec2 metal_and_roughness;
#endif
#if defined(ROUGHNESS_MAP)
uniform sampler2D roughness_map;
#endif
#if defined(NORMAL_MAP)
uniform HIGH sampler2D normal_map;  // small tilts matter to mirrors
uniform float normal_scale;
uniform float handedness;  // of model to world
varying vec4 v_tangent;
#endif
#if defined(OCCLUSION_MAP)
uniform sampler2D occlusion_map;
uniform float occlusion_strength;
#endif
#if defined(EMITS)
uniform vec3 emission;
#endif
#if defined(EMISSION_MAP)
uniform sampler2D emission_map;
#endif

struct Surface {
  vec4 colour;
  vec3 normal;      // world
  vec3 face;        // the same without the normal map
  float metallic;
  float roughness;
  float open_sky;   // 1: nothing hides the sky
  vec3 emission;
};

vec3 decoded_colour(vec3 code) {
#if defined(DECODE_TEXTURE)
  const float slope = 12.92, offset = 0.055, scale = 1.055, exponent = 2.4, linear_end = 0.04045;  // IEC 61966-2-1
  return mix(code / slope, pow((code + offset) / scale, vec3(exponent)), step(linear_end, code));
#else
  return code;
#endif
}

Surface surface_here() {
  Surface s;
  s.colour = base_colour * v_colour;
#if defined(BASE_MAP)
  vec4 texel = texture2D(base_map, BASE_MAP);
  s.colour *= vec4(decoded_colour(texel.rgb), texel.a);
#endif
#if defined(ALPHA_TEST)
  if (s.colour.a < alpha_cutoff) discard;
#endif
  s.metallic = 0.0;
  s.roughness = 1.0;
#if defined(REFLECTS)
  s.metallic = metal_and_roughness.x;
  s.roughness = metal_and_roughness.y;
#endif
#if defined(ROUGHNESS_MAP)
  vec2 rough_metal = texture2D(roughness_map, ROUGHNESS_MAP).gb;
  s.roughness *= rough_metal.x;
  s.metallic *= rough_metal.y;
#endif
  s.normal = normalize(v_normal);
  s.face = gl_FrontFacing ? s.normal : -s.normal;
#if defined(NORMAL_MAP)
  vec3 tilt = 2.0 * texture2D(normal_map, NORMAL_MAP).xyz - 1.0;
  // Averaging different normals in a smaller mip level shortens the result, which is used to increase roughness
  // (Toksvig 2005; twice the variance is added to GGX's squared width). Shortening by 8-bit rounding is ignored.
  float size = clamp(length(tilt), 0.01, 1.0);
  float spread = max((1.0 - size) / size - 0.006, 0.0) * normal_scale * normal_scale;
  s.roughness = sqrt(sqrt(min(pow(s.roughness, 4.0) + 2.0 * spread, 1.0)));
  vec3 along = normalize(v_tangent.xyz - s.normal * dot(s.normal, v_tangent.xyz));
  vec3 upwards = cross(s.normal, along) * (v_tangent.w * handedness);
  s.normal = normalize(along * (tilt.x * normal_scale) + upwards * (tilt.y * normal_scale) + s.normal * tilt.z);
#endif
  if (!gl_FrontFacing) s.normal = -s.normal;
  s.open_sky = 1.0;
#if defined(OCCLUSION_MAP)
  s.open_sky += occlusion_strength * (texture2D(occlusion_map, OCCLUSION_MAP).r - 1.0);
#endif
  s.emission = vec3(0.0);
#if defined(EMITS)
  s.emission = emission;
#endif
#if defined(EMISSION_MAP)
  s.emission *= decoded_colour(texture2D(emission_map, EMISSION_MAP).rgb);
#endif
  return s;
}
