// The camera's sharpening of a picture that the object covers in part. What is seen of the camera's own, the share 1 - a,
// has been sharpened already: shown = composite + amount (detail of the composite - (1 - a) detail of the camera's), where
// detail is Y less its binomial mean over 3 x 3 pixels, in encoded values. It overshoots what lies around it by
// no more than at a straight edge, a quarter of the step: a wall seen through a gap of one pixel between leaves, which a
// lens would have blurred, would shine out by three quarters.
uniform sampler2D camera;     // both filtered: a sample between four pixels is their mean
uniform sampler2D composite;  // the object's share in alpha
uniform vec2 texel;
uniform vec2 last_place;      // of the picture's last pixel, which is repeated
uniform float amount;

const vec3 kLuma = vec3(0.299, 0.587, 0.114);  // Rec. 601

float luma_around(sampler2D picture, vec2 place) {
  vec2 aside = 0.5 * texel;
  vec3 sum = texture2D(picture, min(place + aside, last_place)).rgb + texture2D(picture, place - aside).rgb +
             texture2D(picture, min(place + vec2(aside.x, -aside.y), last_place)).rgb +
             texture2D(picture, min(place + vec2(-aside.x, aside.y), last_place)).rgb;
  return 0.25 * dot(sum, kLuma);
}

// The least and the greatest Y of the pixel and its four neighbours.
vec2 luma_range(vec2 place, float own) {
  vec4 beside = vec4(dot(texture2D(composite, min(place + vec2(texel.x, 0.0), last_place)).rgb, kLuma),
                     dot(texture2D(composite, place - vec2(texel.x, 0.0)).rgb, kLuma),
                     dot(texture2D(composite, min(place + vec2(0.0, texel.y), last_place)).rgb, kLuma),
                     dot(texture2D(composite, place - vec2(0.0, texel.y)).rgb, kLuma));
  vec2 least = min(beside.xy, beside.zw), most = max(beside.xy, beside.zw);
  return vec2(min(own, min(least.x, least.y)), max(own, max(most.x, most.y)));
}

void main() {
  vec2 place = gl_FragCoord.xy * texel;
  vec4 own = texture2D(composite, place);
  float luma = dot(own.rgb, kLuma), detail = luma - luma_around(composite, place);
  float camera_detail = dot(texture2D(camera, place).rgb, kLuma) - luma_around(camera, place);
  float more = amount * (detail - (1.0 - own.a) * camera_detail);
  vec2 range = luma_range(place, luma);
  float over = 0.25 * amount * (range.y - range.x);
  more = clamp(more, min(range.x - over - luma, 0.0), max(range.y + over - luma, 0.0));
  gl_FragColor = vec4(own.rgb + more, own.a);
}
