// The camera's sharpening of a picture that the object covers in part. What is seen of the camera's own, the share 1 - a,
// has been sharpened already: shown = composite + amount (detail of the composite - (1 - a) detail of the camera's), where
// detail is Y less its binomial mean over 3 x 3 pixels, in encoded values.
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

void main() {
  vec2 place = gl_FragCoord.xy * texel;
  vec4 own = texture2D(composite, place);
  float detail = dot(own.rgb, kLuma) - luma_around(composite, place);
  float camera_detail = dot(texture2D(camera, place).rgb, kLuma) - luma_around(camera, place);
  gl_FragColor = vec4(own.rgb + amount * (detail - (1.0 - own.a) * camera_detail), own.a);
}
