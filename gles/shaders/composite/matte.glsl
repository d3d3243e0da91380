// A pixel in which something stands in front of the object: shown = C + (1 - a) (V - B), with the picture's own light
// C, the object's V, and what is behind (B) and in front (F) as their sure neighbours show them (physics 13).
#if defined(MATTE)
uniform sampler2D foreground;  // r: the share that is free, by the mask; a: the mask's confidence
#if defined(MATTE_NODES)
const vec3 kSeen = vec3(0.299, 0.587, 0.114);
const float kLeastContrast2 = 0.0064;  // (.08)^2 of what is behind: a smaller difference of F and B is noise,
const float kLeastLight2 = 4e-6;       // (.002)^2 nor in the dark
const float kPure = 0.3;               // a pixel of which this much at most is of the other kind shows its kind
const float kUnsure = 0.15;
const float kUsual = 0.3;              // pixels that F and B themselves count for
const float kLeafVariance = 25.0;      // over that of what is behind
const float kLeaning = 0.1;            // towards what the pixel usually is

float along(vec3 light, vec3 behind, vec3 towards) { return dot(kSeen * towards, light - behind); }

#if defined(GL_ES)
uniform sampler2D matte_nodes;  // left half: behind; right half: in front
uniform vec4 matte_place;       // the picture's 0..1 to the nodes' 0..1: scale, offset
uniform vec2 matte_last;        // the middle of the last node
uniform vec2 matte_half;        // half a node
uniform vec2 pixel_step;
vec3 light_seen(vec2 place, vec2 pixels_away) {
  vec2 there = clamp(place + pixel_step * pixels_away, vec2(0.0), vec2(1.0));
  return light_of(clamp(camera_at(there), 0.0, 1.0));
}
// Between the nodes around: 0 what is behind, 1 what is in front.
vec4 nodes_at(vec2 place, float kind) {
  vec2 at = clamp(place * matte_place.xy + matte_place.zw, matte_half, matte_last);
  return texture2D(matte_nodes, at * vec2(0.5, 1.0) + vec2(0.5 * kind, 0.0));
}
#endif

// The leaf's and the background's place between B and F differ from leaf to leaf: sums of both kinds' places, and their
// weights.
vec4 kinds_at(vec2 place, vec2 pixels_away, vec3 behind, vec3 towards) {
  float at = clamp(along(light_seen(place, pixels_away), behind, towards), -0.5, 1.5);
  float clear = clamp((kPure - at) / kUnsure, 0.0, 1.0), front = clamp((at - 1.0 + kPure) / kUnsure, 0.0, 1.0);
  return vec4(clear * at, clear, front * at, front);
}
#endif

struct Matte {
  float open_share;  // 1 - a
  vec3 behind;       // open_share times the light behind
};

// `now`: the camera's picture here, linear.
Matte matte_at(vec2 place, vec3 now) {
  vec4 mask = texture2D(foreground, place);
  Matte found;
  found.open_share = mask.r;
  found.behind = mask.r * now;
#if defined(MATTE_NODES)
  bool is_mixed = mask.r > 0.0 && mask.r < 1.0;
  if (ANY(is_mixed)) {
    vec4 clear = nodes_at(place, 0.0), front = nodes_at(place, 1.0);
    bool is_known = is_mixed && clear.a > 0.0;  // what is behind
    if (ANY(is_known)) {
      vec3 behind = clear.rgb / clear.a;
      behind *= behind;
      found.behind = EITHER(is_known, mask.r * behind, found.behind);
      bool are_both = is_known && front.a > 0.0;
      if (ANY(are_both)) {
        vec3 leaf = front.rgb / front.a;
        vec3 towards = leaf * leaf - behind;
        float size2 = dot(kSeen * towards, towards), doubt = kLeastContrast2 * dot(kSeen * behind, behind) + kLeastLight2;
        vec3 scaled = towards / (size2 + 1e-9);
        vec4 kinds = vec4(0.0, kUsual, kUsual, kUsual);
        for (int y = -2; y <= 2; ++y)
          for (int x = -2; x <= 2; ++x)
            if (x * x + y * y <= 4) kinds += kinds_at(place, vec2(float(x), float(y)), behind, scaled);
        float low = kinds.x / kinds.y, high = kinds.z / kinds.w;
        float seen = (along(now, behind, scaled) - low) / max(high - low, 0.1);
        float usual = 1.0 - mask.r;
        float covered = clamp(seen + kLeaning * (usual - 0.5), 0.0, 1.0);
        covered = mix(usual, mix(covered, usual, mask.a), size2 / (size2 + doubt));
        float open_share = 1.0 - covered;
        // What F and B do not explain belongs to both by their share of the pixel's variance; where leaves sway, leaf
        // differs from leaf more than what is behind from place to place.
        float leaf_variance = mix(kLeafVariance, 1.0, mask.a);
        float share = open_share * open_share / (open_share * open_share + leaf_variance * covered * covered);
        vec3 open_behind = max(open_share * behind + share * (now - behind - covered * towards), 0.0);
        found.open_share = EITHER(are_both, open_share, found.open_share);
        found.behind = EITHER(are_both, open_behind, found.behind);
      }
    }
  }
#endif
  return found;
}
#endif
