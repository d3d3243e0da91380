// Tone mapping. Compiles as GLSL ES 1.00 and as C++ (base/sky/sky_text.hpp).

const vec3 kLuminanceOfSrgb = vec3(0.2126, 0.7152, 0.0722);  // row Y of srgb_to_xyz(), calib/colour/colorimetry.hpp
FUNCTION real luminance_of(vec3 linear_srgb) { return dot(linear_srgb, kLuminanceOfSrgb); }

// The factor by which a colour's distance from grey is scaled. `needed`: that distance relative to the gamut boundary.
// Colours well inside are kept; the others are compressed smoothly to within the boundary, so that none is clipped and
// different colours stay different.
FUNCTION real kept_saturation(real needed) {
  const real knee = 0.8;
  real beyond = max(needed - knee, 0.0);
  real reached = min(needed, knee) + (1.0 - knee) * beyond / (beyond + (1.0 - knee));
  return needed > knee ? reached / needed : 1.0;
}

// Maps any light to linear 0 .. 1. The luminance is mapped by 1 - (1 + x / 2)^-2, whose shoulder is long enough for the
// light around the sun: twenty times what is shown as .5 is still not white. Colours near or outside the gamut boundary
// are desaturated towards the grey of their luminance, which keeps both luminance and dominant wavelength.
FUNCTION vec3 tone_mapped(vec3 light, real exposure) {
  real luminance = max(luminance_of(light), 1e-12);
  real left = 1.0 / (1.0 + 0.5 * exposure * luminance);
  left *= left;
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
