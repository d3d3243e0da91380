// How much light passes a straight path through the air (estimator/air_path.hpp tells of the numbers). GLSL ES 1.00 and
// C++ (base/sky_text.hpp) alike.

// AirCoefficients of base/dome_function.hpp: a sum over two wavelengths for each of linear red, green and blue.
struct PathAir {
  vec3 weight[2];
  vec3 molecules_per_m[2];
  vec3 aerosol_per_m[2];
  vec3 ozone[2];
};

const real kAerosolHeight_m = 1200.0;

// What stands above an altitude: metres of sea-level air, metres of sea-level haze, share of the ozone layer.
FUNCTION vec3 air_above(real altitude_m) {
  real pressure = pow(1.0 - min(altitude_m, 11000.0) / 44330.77, 5.25588) * exp(-max(altitude_m - 11000.0, 0.0) / 6341.62);
  real ozone = (1.0 + exp(-22500.0 / 4700.0)) / (1.0 + exp((altitude_m - 22500.0) / 4700.0));
  return vec3(8434.5 * pressure, kAerosolHeight_m * exp(-altitude_m / kAerosolHeight_m), ozone);
}

// The same along a path: s (N(h0) - N(h1)) / (h1 - h0), where U Eq 3.3 gives negative depths. The ends are
// kept 50 m apart; the second factor is the path's sag below the line between its ends' altitudes.
FUNCTION vec3 air_along(real altitude_0_m, real altitude_1_m, real length_m) {
  real middle = 0.5 * (altitude_0_m + altitude_1_m);
  real rise = abs(altitude_1_m - altitude_0_m);
  real apart = max(rise, 50.0);
  vec3 column = (air_above(middle - 0.5 * apart) - air_above(middle + 0.5 * apart)) * (length_m / apart);
  vec2 scale_height_m = vec2(8000.0, kAerosolHeight_m);
  vec2 steepness = rise / scale_height_m;
  vec2 sag = length_m * (length_m / (12742000.0 * scale_height_m)) / sqrt(vec2(36.0) + steepness * steepness);
  return column * vec3(exp(min(sag, vec2(4.0))), 1.0);
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

// All the air above an altitude, at a slant: to 3 % of Chapman's function.
FUNCTION vec3 transparency_to_space(PathAir air, vec3 above, real cos_zenith) {
  real c = max(cos_zenith, 0.0);
  vec2 slant = 2.0 / (c + sqrt(c * c + vec2(0.0032, 0.00048)));  // 8 H / (pi R)
  return transparency_of(air, above * vec3(slant, slant.x));
}

// Of the light that is lost on a path, what haze takes.
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
