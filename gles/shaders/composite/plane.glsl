// What the display lays over the camera's picture by itself: premultiplied encoded values with one alpha for all
// channels, shown = rgb + (1 - a) behind. Over the background of now that is exact; `kept` = 1 - a makes it follow a
// background that changes a little, like blending in linear light does.
#if defined(PLANE)
const float kReach = 16.0 / 255.0;        // the change of the background that is followed best
const float kTolerance = 0.25 / 255.0;    // colour given up for a better alpha

// `own`: the object's part of the light; `coverage`: of the pixel.
vec4 for_plane(vec3 behind, vec3 shown, vec3 own, float coverage) {
  vec3 now = clamp(behind, 0.0, 1.0);
  vec3 low = max(now - kReach, 0.0), high = min(now + kReach, 1.0), change = high - low;
  vec3 follows = encoded(light_of(high) * (1.0 - coverage) + own) - encoded(light_of(low) * (1.0 - coverage) + own);
  float kept = dot(follows, change) / dot(change, change);  // least squares over the channels
  vec3 wanted = clamp(shown, 0.0, 1.0);
  // No colour may be below 0 or above alpha.
  vec3 most = min((wanted + kTolerance) / max(now, 0.001), (1.0 - wanted + kTolerance) / max(1.0 - now, 0.001));
  kept = clamp(min(kept, min(most.r, min(most.g, most.b))), 0.0, 1.0);
  kept = floor(kept * 255.0 + 0.5) / 255.0;
  return vec4(clamp(wanted - kept * now, 0.0, 1.0 - kept), 1.0 - kept);
}
#endif
