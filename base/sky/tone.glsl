// From light to what a screen can show. GLSL ES 1.00 and C++ (base/sky/sky_text.hpp) alike.

const vec3 kLuminanceOfSrgb = vec3(0.2126, 0.7152, 0.0722);  // the row of Y in srgb_to_xyz() of calib/colour/colorimetry.hpp
FUNCTION real luminance_of(vec3 linear_srgb) { return dot(linear_srgb, kLuminanceOfSrgb); }

// What is left of a colour's distance from grey. `needed`: that distance as a part of the way to the gamut's wall. Colours
// well inside keep theirs; the others are led smoothly below the wall, however far out they are: none is clipped, no two
// become one.
FUNCTION real kept_saturation(real needed) {
  const real knee = 0.8;
  real beyond = max(needed - knee, 0.0);
  real reached = min(needed, knee) + (1.0 - knee) * beyond / (beyond + (1.0 - knee));
  return needed > knee ? reached / needed : 1.0;
}

// Light of any strength to linear 0 .. 1. The luminance goes through 1 - exp(-x); the colour keeps its dominant
// wavelength: what it loses, it loses towards the grey of its luminance, so that luminance and hue both hold.
FUNCTION vec3 tone_mapped(vec3 light, real exposure) {
  real luminance = max(luminance_of(light), 1e-12);
  real left = exp(-exposure * luminance);
  real shown = 1.0 - left;
  vec3 from_grey = light / luminance - vec3(1.0);
  vec3 needed = max(from_grey * (shown / max(left, 1e-30)), -from_grey);
  real kept = kept_saturation(max(max(needed.x, needed.y), needed.z));
  return shown * (vec3(1.0) + kept * from_grey);
}

// IEC 61966-2-1.
const real kSrgbLinearEnd = 0.0031308;
const real kSrgbSlope = 12.92;
const real kSrgbScale = 1.055;
const real kSrgbOffset = 0.055;
const real kSrgbExponent = 2.4;
FUNCTION vec3 srgb_encoded(vec3 linear) {
  vec3 held = clamp(linear, 0.0, 1.0);
  vec3 power = kSrgbScale * pow(max(held, vec3(1e-6)), vec3(1.0 / kSrgbExponent)) - vec3(kSrgbOffset);
  return mix(kSrgbSlope * held, power, step(vec3(kSrgbLinearEnd), held));
}
