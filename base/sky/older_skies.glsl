// Older sky models for comparison: Hoffman and Preetham 2002, Nielsen 2003 (U Eq 2.24-2.30). Single scattering in
// closed form, for both sky and land. Compiles as GLSL ES 1.00 and as C++ (base/sky/sky_text.hpp).

// For linear red, green and blue, per metre at sea level.
struct OlderAir {
  vec3 rayleigh_per_m;
  vec3 mie_per_m;
  vec3 sunlight;     // irradiance / pi on a surface facing the sun at the ground, in the picture's unit of light
  real asymmetry;    // g of the Henyey-Greenstein phase function
  real altitude_m;   // of the observer
};

const real kOlderRayleighHeight_m = 8400.0;
const real kOlderMieHeight_m = 1250.0;

// Path lengths of air and haze out to space, by the cosine of the zenith angle; constant below the horizon. Kasten and
// Young 1989:
// 1 / (cos z + a (b - z)^-c), angles in degrees.
const real kKastenA = 0.50572;
const real kKastenB_deg = 96.07995;
const real kKastenC = 1.6364;
const real kKastenAtHorizon_deg = 6.07995;  // b - 90
const real kDegreesPerRadian = 57.29578;
FUNCTION real older_air_mass(real cos_zenith) {
  real held = max(cos_zenith, 0.0);
  real degrees_left = max(kKastenB_deg - kDegreesPerRadian * acos(min(held, 1.0)), kKastenAtHorizon_deg);
  return 1.0 / (held + kKastenA * pow(degrees_left, -kKastenC));
}
FUNCTION vec2 older_sky_path_m(real cos_zenith) {
  return older_air_mass(cos_zenith) * vec2(kOlderRayleighHeight_m, kOlderMieHeight_m);
}

// Light scattered into a path (Lin), and the transmittance F for what lies behind it: L = L0 F + Lin (U Eq 2.24-2.26).
// band: the share of cos^2 in Rayleigh's phase function: 1; Nielsen 1/2 (U Eq 2.29), against the dark band.
FUNCTION vec3 older_transmittance(OlderAir air, vec2 path_m) {
  return exp(-(air.rayleigh_per_m * path_m.x + air.mie_per_m * path_m.y));
}
FUNCTION vec3 older_scattered(OlderAir air, vec3 transmittance, vec2 density, real cos_sun, real band) {
  real g = air.asymmetry;
  real rayleigh_phase = 3.0 / 16.0 * (1.0 + band * cos_sun * cos_sun);
  real mie_phase = 0.25 * (1.0 - g * g) / pow(1.0 + g * g - 2.0 * g * cos_sun, 1.5);
  vec3 rayleigh = air.rayleigh_per_m * density.x;
  vec3 mie = air.mie_per_m * density.y;
  return (rayleigh * rayleigh_phase + mie * mie_phase) / (rayleigh + mie) * air.sunlight * (vec3(1.0) - transmittance);
}

FUNCTION vec3 hoffman_preetham_sky(OlderAir air, real cos_zenith, real cos_sun) {
  vec3 left = older_transmittance(air, older_sky_path_m(cos_zenith));
  return older_scattered(air, left, vec2(1.0), cos_sun, 1.0);
}

// The air thins with altitude. Nielsen took the lengths from tables of his own; here they are the exponentials that the
// tables approximate.
FUNCTION vec3 nielsen_sky(OlderAir air, real cos_zenith, real cos_sun) {
  vec2 density = exp(-air.altitude_m / vec2(kOlderRayleighHeight_m, kOlderMieHeight_m));
  vec3 left = older_transmittance(air, older_sky_path_m(cos_zenith) * density);
  return older_scattered(air, left, density, cos_sun, 0.5);
}

FUNCTION vec3 hoffman_preetham_object(OlderAir air, vec3 object, real length_m, real cos_sun) {
  vec3 left = older_transmittance(air, vec2(length_m));
  return object * left + older_scattered(air, left, vec2(1.0), cos_sun, 1.0);
}

// The density at the path's midpoint.
FUNCTION vec3 nielsen_object(OlderAir air, vec3 object, real object_altitude_m, real length_m, real cos_sun) {
  vec2 density = exp(-0.5 * (air.altitude_m + object_altitude_m) / vec2(kOlderRayleighHeight_m, kOlderMieHeight_m));
  vec3 left = older_transmittance(air, length_m * density);
  return object * left + older_scattered(air, left, density, cos_sun, 0.5);
}

// Preetham 1999: the Perez distribution of Y, x and y. zenith: their values at the zenith over the distribution's value
// there (physics 1).
struct PerezSky {
  vec3 zenith;
  vec3 a;
  vec3 b;
  vec3 c;
  vec3 d;
  vec3 e;
};

// XYZ to linear sRGB with the digits of Lindbloom's tables; calib/colour/colorimetry.hpp has the standard's, which are
// rounded to four places.
const vec3 kRedOfXyz = vec3(3.2404542, -1.5371385, -0.4985314);
const vec3 kGreenOfXyz = vec3(-0.9692660, 1.8760108, 0.0415560);
const vec3 kBlueOfXyz = vec3(0.0556434, -0.2040259, 1.0572252);
FUNCTION vec3 linear_srgb_of_Yxy(vec3 colour) {
  vec3 xyz = vec3(colour.y / colour.z, 1.0, (1.0 - colour.y - colour.z) / colour.z) * colour.x;
  return vec3(dot(xyz, kRedOfXyz), dot(xyz, kGreenOfXyz), dot(xyz, kBlueOfXyz));
}

FUNCTION vec3 preetham_sky(PerezSky sky, real cos_zenith, real cos_sun) {
  real gamma = acos(clamp(cos_sun, -1.0, 1.0));
  vec3 around_zenith = vec3(1.0) + sky.a * exp(sky.b / max(cos_zenith, 0.001));
  vec3 around_sun = vec3(1.0) + sky.c * exp(sky.d * gamma) + sky.e * (cos_sun * cos_sun);
  return linear_srgb_of_Yxy(sky.zenith * around_zenith * around_sun);
}
