// The sun's frame: x and y in texels from the middle of a map, z 0..1 away from the sun. A map shows the object from
// one point of the sun's disc: as from its middle, but shifted in proportion to depth.
uniform vec2 sun_spread;      // shift in texels at depth 1 for a point on the disc's edge
uniform float sun_map_texels;  // along a side of one map

// 16 points for equal parts of the unit disc: 4 on an inner and 12 on an outer ring, so that their mean and variance
// are the disc's in every direction.
const float kTurn = 6.2831853;
const float kInnerRing = 0.3535534;  // radii: sqrt(1/8) and sqrt(5/8)
const float kOuterRing = 0.7905694;
const float kOuterTurned = 0.05;  // turns, so that no outer point lies in the direction of an inner one
vec2 sun_point(float number) {
  float outer = step(3.5, number);
  float turn = kTurn * ((number - 4.0 * outer) / mix(4.0, 12.0, outer) + kOuterTurned * outer);
  return mix(kInnerRing, kOuterRing, outer) * vec2(cos(turn), sin(turn));
}
// Each map is offset by a fraction of a texel (two-dimensional sequence of Roberts 2018), so that together they have a
// higher resolution.
const vec2 kRoberts = vec2(0.7548777, 0.5698403);
vec2 place_in_map(vec3 point, float number) {
  return point.xy + (point.z - 0.5) * sun_spread * sun_point(number) + 0.5 * sun_map_texels +
         fract(number * kRoberts) - 0.5;
}
