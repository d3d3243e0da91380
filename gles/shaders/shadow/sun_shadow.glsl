// The share of the sun's disc visible from this fragment, 0..1.
#include "sun.glsl"
#include "sun_maps.glsl"

#if defined(SUN_SHADOW)
uniform highp sampler2D sun_maps;  // 4 x 4 maps
uniform mat3 sun_from_world;       // vectors in metres, to the sun's frame
uniform mat3 sun_from_normal;      // plane normals, to the sun's frame
uniform float step_off_m;          // offset from surfaces at grazing sun
uniform float steepest;            // slope of a plane, depth per texel
uniform float depth_margin;
varying vec3 v_sun;
#if defined(ONE_MAP_EACH)
uniform vec2 lattice_first;        // lattice coordinates at gl_FragCoord 0.5
#endif

float depth_at(vec2 texel, float number) {
  vec2 corner = vec2(mod(number, 4.0), floor(number / 4.0)) * sun_map_texels;
  vec2 inside = clamp(texel, vec2(0.0), vec2(sun_map_texels - 1.0));
  vec4 stored = texture2D(sun_maps, (corner + inside + 0.5) / (4.0 * sun_map_texels));
#if defined(PACKED_DEPTH)
  return dot(stored, vec4(1.0, 1.0 / 255.0, 1.0 / 65025.0, 1.0 / 16581375.0));
#else
  return stored.r;
#endif
}

// Depth gradient per texel of the fragment's plane. Comparing with the plane's depth at each texel prevents slopes from
// shadowing themselves. Taken from the face if the driver has derivatives, else from the normal.
vec2 slope_here(vec3 normal) {
#if defined(FACE_SLOPES)
  vec3 face = cross(dFdx(v_sun), dFdy(v_sun));
#else
  vec3 face = sun_from_normal * normal;
#endif
  return clamp(-face.xy / (abs(face.z) < 1e-12 ? 1e-12 : face.z), -steepest, steepest);
}

// 1: nothing in this texel lies in front of the plane. The last hundredth of the maps' depth is always empty, so the
// plane's depth is limited to it: empty texels, which hold 1, then always pass.
float passed(vec2 texel, vec2 at, float depth, vec2 slope, float number) {
  return step(min(depth + dot(slope, texel + 0.5 - at) - depth_margin, 0.995), depth_at(texel, number));
}

#if defined(ONE_MAP_EACH)
float seen_from(vec3 point, vec2 slope, float number) {
  vec2 at = place_in_map(point, number);
  slope /= 1.0 + dot(slope, sun_spread * sun_point(number));
  vec2 corner = floor(at - 0.5), share = at - 0.5 - corner;
  float x0y0 = passed(corner, at, point.z, slope, number);
  float x1y0 = passed(corner + vec2(1.0, 0.0), at, point.z, slope, number);
  float x0y1 = passed(corner + vec2(0.0, 1.0), at, point.z, slope, number);
  float x1y1 = passed(corner + vec2(1.0, 1.0), at, point.z, slope, number);
  return mix(mix(x0y0, x1y0, share.x), mix(x0y1, x1y1, share.x), share.y);
}
#else
float seen_from(vec3 point, vec2 slope, float number) {
  vec2 at = place_in_map(point, number);
  slope /= 1.0 + dot(slope, sun_spread * sun_point(number));
  return passed(floor(at), at, point.z, slope, number);
}
#endif

// normal: of the surface as modelled, without its normal map.
float sun_seen(vec3 normal) {
  // Round columns consist of flat faces; an offset from the face keeps adjacent ones from shadowing each other.
  float facing = dot(normal, sun_direction), grazing = length(cross(normal, sun_direction));
  vec3 point = v_sun + sun_from_world * normal * (step_off_m * grazing);
  vec2 slope = slope_here(normal);
#if defined(ONE_MAP_EACH)
  // Each of a pixel's 17 samples uses another of the 16 maps; one map is used twice.
  vec2 place = gl_FragCoord.xy - 0.5 + lattice_first;
  float number = floor(mod(4.0 * place.x - place.y + 0.5, 17.0));
  float seen = seen_from(point, slope, number > 15.5 ? 5.0 : number);
#else
  float seen = 0.0;
  for (int i = 0; i < 16; ++i) seen += seen_from(point, slope, float(i)) / 16.0;
#endif
  // Slopes beyond the limit get almost no light, and their shadow cannot be determined.
  return facing < 0.0 ? seen : mix(1.0, seen, smoothstep(0.017, 0.025, facing));
}
#else
float sun_seen(vec3 normal) { return 1.0; }
#endif
