// The radiance of a surface towards the eye under sun and sky.
#include "surface.glsl"
#include "sun.glsl"
#include "sky_atlas.glsl"
#include "fog_light.glsl"
#include "sun_shadow.glsl"

#if defined(UNLIT) || defined(EMITS)
uniform vec3 white_card;       // radiance of a horizontal white card in the open, under sun and sky
#endif
#if defined(REFLECTS)
uniform vec3 head_on_reflectance;
uniform float edge_reflectance;
varying vec3 v_to_eye;         // world
#endif

#if defined(REFLECTS)
const float kSunDisc = 5.4e-6;  // its solid angle over 4 pi (base/sky/sun_disc.hpp)

// GGX specular lobe of the sun with Schlick's Fresnel, times pi. The lobe is widened by the sun's disc, so that a
// smooth mirror shows the disc's own radiance.
vec3 sun_lobe(vec3 n, vec3 eye, float across, float roughness, vec3 f0, vec3 f90) {
  float towards = dot(n, sun_direction);
  if (towards <= 0.0) return vec3(0.0);
  vec3 facet = normalize(eye + sun_direction);
  float nh = clamp(dot(n, facet), 0.0, 1.0);
  vec3 aside = cross(n, facet);  // its square is 1 - nh^2, without the loss of digits
  float a2 = pow(roughness, 4.0) + kSunDisc;
  float spread = dot(aside, aside) + nh * nh * a2;
  float hidden = towards * sqrt(across * across * (1.0 - a2) + a2) + across * sqrt(towards * towards * (1.0 - a2) + a2);
  float edge = pow(1.0 - clamp(dot(eye, facet), 0.0, 1.0), 5.0);
  return (f0 + (f90 - f0) * edge) * (a2 / spread / spread * 0.5 / hidden);
}

// Light from multiple reflections between facets (Fdez-Aguera 2019). `once`: light reflected a single time; `all`: the
// same for a white mirror.
const float kMeanOfEdge = 21.0;  // the hemispherical average of Schlick's edge term is 1/21
vec3 from_between(vec3 once, vec3 f0, vec3 f90, float all) {
  vec3 mean = f0 + (f90 - f0) / kMeanOfEdge;
  return once * mean * (1.0 - all) / (1.0 - mean * (1.0 - all));
}

// Single reflection, reflection between facets, and diffuse light from below the surface: the sum conserves energy.
// Metal and dielectric are mixed linearly.
vec3 lit(Surface s) {
  vec3 body = in_channels(s.colour.rgb);
  vec3 coat = in_channels(head_on_reflectance);
  vec3 coat_edge = vec3(edge_reflectance);
  vec3 eye = normalize(v_to_eye);
  float across = clamp(dot(s.normal, eye), 0.002, 1.0);
  vec4 back = given_back(across, s.roughness);
  vec3 coat_once = coat * (back.x - back.y) + coat_edge * back.y;
  vec3 metal_once = body * (back.x - back.y) + back.y;
  vec3 coat_between = from_between(coat_once, coat, coat_edge, back.x);
  vec3 once = mix(coat_once, metal_once, s.metallic);
  vec3 between = mix(coat_between, from_between(metal_once, body, vec3(1.0), back.x), s.metallic);
  vec3 coloured = (1.0 - s.metallic) * body * (1.0 - coat_once - coat_between);

  // The reflection of a rough surface leans towards its normal, and its blur differs from that at normal incidence.
  vec3 mirrored = mirrored_sky(mix(s.normal, reflect(-eye, s.normal), back.z), back.w);
  float open_image = clamp(pow(across + s.open_sky, exp2(-16.0 * s.roughness - 1.0)) - 1.0 + s.open_sky, 0.0, 1.0);
  vec3 glint = sun_light * (max(dot(s.normal, sun_direction), 0.0) *
                            sun_lobe(s.normal, eye, across, s.roughness, mix(coat, body, s.metallic),
                                     mix(coat_edge, vec3(1.0), s.metallic)));
#if defined(FOG_LIGHT)
  mirrored = mirrored * light_through_fog() + fog_glow();
  glint *= sun_through_fog();
#endif
  float seen = sun_seen(s.face);
  return (coloured + between) * (s.open_sky * sky_here(s.normal) + seen * sun_here(s.normal)) +
         open_image * once * mirrored + seen * glint;
}
#else
vec3 lit(Surface s) {
  return in_channels(s.colour.rgb) * (s.open_sky * sky_here(s.normal) + sun_seen(s.face) * sun_here(s.normal));
}
#endif

vec3 radiance_of(Surface s) {
#if defined(UNLIT)
  return in_channels(s.colour.rgb) * white_card;
#elif defined(EMITS)
  return lit(s) + max(albedo_to_channels * s.emission, 0.0) * white_card;
#else
  return lit(s);
#endif
}
