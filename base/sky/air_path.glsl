// How much light passes a straight path between any two altitudes up to 100 km: the corrected form of U's transparency
// integral (U Eq 3.2-3.4 give negative depths; docs/sky.md). Valid for paths that dip below their lower end by less
// than a scale height: lines of sight of 200 km, but not tangents through the atmosphere. Compiles as GLSL ES 1.00 and
// as C++ (base/sky/sky_text.hpp).

// AirCoefficients of base/sky/dome_function.hpp: a sum over two wavelengths for each of linear red, green and blue.
struct PathAir {
  vec3 weight[2];
  vec3 molecules_per_m[2];
  vec3 aerosol_per_m[2];
  vec3 ozone[2];
};

const real kEarthRadius_m = 6371000.0;  // base/earth.hpp's

// Scale heights of air and of haze.
const real kAirHeight_m = 8000.0;
const real kAerosolHeight_m = 1200.0;

// US standard atmosphere 1976: a troposphere of constant lapse rate, above it a constant temperature. The real pressure
// is 6 % lower at 30 km, where 1 % of the air is left.
const real kTropopause_m = 11000.0;
const real kTemperatureOverLapse_m = 44330.77;  // height at which the lapse rate would reach 0 K
const real kPressureExponent = 5.25588;
const real kStratosphereHeight_m = 6341.62;  // scale height
const real kAirColumn_m = 8434.5;  // sea-level pressure / (density * g): height of the air column at constant density

// Green's ozone profile: height of the layer's middle, and its scale.
const real kOzoneMiddle_m = 22500.0;
const real kOzoneWidth_m = 4700.0;

// Vertical columns above an altitude: metres of sea-level air, metres of sea-level haze, share of the ozone layer.
FUNCTION vec3 air_above(real altitude_m) {
  real pressure = pow(1.0 - min(altitude_m, kTropopause_m) / kTemperatureOverLapse_m, kPressureExponent) *
                  exp(-max(altitude_m - kTropopause_m, 0.0) / kStratosphereHeight_m);
  real ozone = (1.0 + exp(-kOzoneMiddle_m / kOzoneWidth_m)) / (1.0 + exp((altitude_m - kOzoneMiddle_m) / kOzoneWidth_m));
  return vec3(kAirColumn_m * pressure, kAerosolHeight_m * exp(-altitude_m / kAerosolHeight_m), ozone);
}

// The same along a path of a length >= |difference of the altitudes|: s (N(h0) - N(h1)) / (h1 - h0), N = air_above,
// exact over a flat Earth. The ends are kept 50 m apart, which leaves no 0 / 0 and costs 1e-4 at most. On a round Earth
// the path's altitude sags below the straight line between its ends', by up to s^2 / 8R in the middle: each column
// grows by exp(s^2 / (2 R H) / sqrt(36 + ((h1 - h0) / H)^2)), H its scale height.
const real kClosestEnds_m = 50.0;
const real kSagOfLevelPath = 36.0;
const real kLargestSag = 4.0;  // of the exponent
FUNCTION vec3 air_along(real altitude_0_m, real altitude_1_m, real length_m) {
  real middle = 0.5 * (altitude_0_m + altitude_1_m);
  real rise = abs(altitude_1_m - altitude_0_m);
  real apart = max(rise, kClosestEnds_m);
  vec3 column = (air_above(middle - 0.5 * apart) - air_above(middle + 0.5 * apart)) * (length_m / apart);
  vec2 scale_height_m = vec2(kAirHeight_m, kAerosolHeight_m);
  vec2 steepness = rise / scale_height_m;
  vec2 sag = length_m * (length_m / (2.0 * kEarthRadius_m * scale_height_m)) / sqrt(vec2(kSagOfLevelPath) + steepness * steepness);
  return column * vec3(exp(min(sag, vec2(kLargestSag))), 1.0);
}

FUNCTION vec3 transparency_of(PathAir air, vec3 path) {
  vec3 left = vec3(0.0);
  for (int n = 0; n < 2; ++n)
    left += air.weight[n] *
            exp(-(air.molecules_per_m[n] * path.x + air.aerosol_per_m[n] * path.y + air.ozone[n] * path.z));
  return clamp(left, 0.0, 1.0);
}

FUNCTION vec3 path_transparency(PathAir air, real altitude_0_m, real altitude_1_m, real length_m) {
  return transparency_of(air, air_along(altitude_0_m, altitude_1_m, length_m));
}

// All the air above an altitude along a slanted ray: within 3 % of Chapman's function.
const vec2 kSlantOfLevelRay = vec2(0.0032, 0.00048);  // 8 H / (pi R) of air and of haze
FUNCTION vec3 transparency_to_space(PathAir air, vec3 above, real cos_zenith) {
  real c = max(cos_zenith, 0.0);
  vec2 slant = 2.0 / (c + sqrt(c * c + kSlantOfLevelRay));
  return transparency_of(air, above * vec3(slant, slant.x));
}

// The share of the light lost on a path that is lost to haze.
FUNCTION vec3 share_of_haze(PathAir air, vec3 path) {
  vec3 haze = vec3(0.0);
  vec3 all = vec3(1e-9);
  for (int n = 0; n < 2; ++n) {
    vec3 aerosol = air.weight[n] * air.aerosol_per_m[n] * path.y;
    haze += aerosol;
    all += aerosol + air.weight[n] * (air.molecules_per_m[n] * path.x + air.ozone[n] * path.z);
  }
  return haze / all;
}
