// The sky as a function of direction (base/sky/dome_function.hpp), what lies in front of it, and the sun. Compiles as
// GLSL ES 1.00 and as C++ (base/sky/sky_text.hpp). Light is linear sRGB, cd/m2.

const int kAngles = 6;  // kDomeAngles and kDomePowers of base/sky/dome_function.hpp
const int kPowers = 7;
struct DomeSky {
  real horizon_sine;
  real steepness;
  vec3 lobes;
  vec3 coefficients[kAngles * kPowers];
};

// Henyey-Greenstein lobe, normalised to 1 towards the sun.
FUNCTION real dome_lobe(real asymmetry, real cos_sun) {
  real part = (1.0 - asymmetry) * (1.0 - asymmetry) / (1.0 + asymmetry * asymmetry - 2.0 * asymmetry * cos_sun);
  return part * sqrt(max(part, 0.0));
}

// cos_zenith and cos_sun may belong to different directions: see object_through_air. Colours outside sRGB have a
// negative channel.
FUNCTION vec3 dome_sky_light(DomeSky sky, real cos_zenith, real cos_sun) {
  real above = max(0.0, (cos_zenith - sky.horizon_sine) / (1.0 - sky.horizon_sine));
  real u = 1.0 / (1.0 + sky.steepness * above);
  vec3 sum = vec3(0.0);
  for (int k = kPowers - 1; k >= 0; --k) {
    vec3 factor = sky.coefficients[k] + cos_sun * (sky.coefficients[kPowers + k] + cos_sun * sky.coefficients[2 * kPowers + k]) +
                  dome_lobe(sky.lobes.x, cos_sun) * sky.coefficients[3 * kPowers + k] +
                  dome_lobe(sky.lobes.y, cos_sun) * sky.coefficients[4 * kPowers + k] +
                  dome_lobe(sky.lobes.z, cos_sun) * sky.coefficients[5 * kPowers + k];
    sum = sum * u + factor;
  }
  return sum;
}

// The sun's disc: off is the angle from its middle in solar radii. Limb darkening is 1 - d (1 - cos), d from Neckel and
// Labs 1994 at the channels' wavelengths; the mean is kept.
FUNCTION vec3 sun_disc_light(vec3 mean_luminance, real off) {
  vec3 darkening = vec3(0.52, 0.60, 0.74);
  real cosine = sqrt(max(1.0 - off * off, 0.0));
  return mean_luminance * (vec3(1.0) - darkening * (1.0 - cosine)) / (vec3(1.0) - darkening / 3.0);
}
// The share of a pixel that the disc covers; blur: half the pixel's width in solar radii. Encoded colours are mixed,
// not light: in linear light a thousandth of the disc would outshine the sky and its edge would be aliased.
FUNCTION real sun_coverage(real off, real blur) { return 1.0 - clamp((off - 1.0) / (2.0 * blur) + 0.5, 0.0, 1.0); }

const real kInversePi = 0.31830989;
const real kAlbedoAround = 0.2;  // of the ground that lights upright land

// Diffuse land under sun and sky. sun: illuminance on a plane facing it; sky: illuminance on level ground; both in lux.
FUNCTION vec3 land_light(vec3 albedo, real cos_sun_to_normal, real normal_up, vec3 sun, vec3 sky) {
  vec3 ground_around = kAlbedoAround * 0.5 * (1.0 - normal_up) * (sky + 0.5 * sun);
  return albedo * (max(cos_sun_to_normal, 0.0) * sun + 0.5 * (1.0 + normal_up) * sky + ground_around) * kInversePi;
}

// Interpolation weight of an altitude between the two whose skies are known, following the air's density.
FUNCTION real way_between_altitudes(real altitude_m, real lower_m, real higher_m) {
  const real thin_m = 3000.0;  // between that of haze and that of air
  real from = exp(-lower_m / thin_m);
  real to = exp(-higher_m / thin_m);
  return clamp((from - exp(-altitude_m / thin_m)) / max(from - to, 1e-6), 0.0, 1.0);
}

// The light that a path through the air adds, from the skies of a lower and a higher altitude that bracket it.
struct AirBetween {
  DomeSky lower;
  DomeSky higher;
  vec2 altitude_m;  // of the two
  PathAir air;
  vec3 sun_lower;  // on a plane facing it, lux
  vec3 sun_higher;
  vec3 below_lower;  // light_from_below
  vec3 below_higher;
};

// Brightness of the ground below minus that of the sky above, away from the sun. The bright sky around the sun is left
// out because mirroring the zenith angle keeps its angle to the view.
FUNCTION vec3 light_from_below(DomeSky sky, vec3 ground, real cos_sun_zenith) {
  const real up = 0.70710678;  // at 45 deg
  real across = up * sqrt(max(1.0 - cos_sun_zenith * cos_sun_zenith, 0.0));
  vec3 beside = dome_sky_light(sky, up, up * cos_sun_zenith);
  vec3 opposite = dome_sky_light(sky, up, up * cos_sun_zenith - across);
  return ground - 0.5 * (beside + opposite);
}

// A view downwards may have an angle to the sun that no view above the horizon has at the mirrored zenith angle; takes
// the nearest possible one.
FUNCTION real held_cos_sun(real cos_zenith, real cos_sun, real cos_sun_zenith) {
  real across = sqrt(max((1.0 - cos_zenith * cos_zenith) * (1.0 - cos_sun_zenith * cos_sun_zenith), 0.0));
  real middle = cos_zenith * cos_sun_zenith;
  return clamp(cos_sun, middle - across, middle + across);
}

// The reference atmosphere's haze scatters .88 in a forward lobe and .12 in a backward one. Because lobes are
// normalised to 1 towards the sun, each is multiplied by its share times (1 + g) / (1 - g)^2, with g the asymmetry.
const real kHazeAlbedo = 0.93;
const real kForwards = 0.8;
const real kForwardsHeight = 39.6;
const real kBackwards = -0.45;
const real kBackwardsHeight = 0.0314;
const real kInverseFourPi = 0.0795775;

// The share per steradian of the sunlight lost on the path that is singly scattered towards the eye: by molecules
// (Rayleigh) and by haze.
FUNCTION vec2 scattered_once(real cos_sun) {
  real haze = kForwardsHeight * dome_lobe(kForwards, cos_sun) + kBackwardsHeight * dome_lobe(kBackwards, cos_sun);
  return kInverseFourPi * vec2(0.75 * (1.0 + cos_sun * cos_sun), kHazeAlbedo * haze);
}

// The factor of a sky's light that is due to the amount of air and the sunlight reaching it. Skies are interpolated
// between altitudes after division by this, since they do not change monotonically themselves.
const real kLitByAir = 0.3;  // added to direct sunlight: air in shadow is lit by sunlit air
const real kLeastAir = 1e-4;
FUNCTION vec3 lit_air(PathAir air, real altitude_m, real cos_zenith, real cos_sun_zenith) {
  vec3 above = air_above(altitude_m);
  return max(vec3(1.0) - transparency_to_space(air, above, cos_zenith), vec3(kLeastAir)) *
         (vec3(kLitByAir) + transparency_to_space(air, above, cos_sun_zenith));
}

// For light uniform over a hemisphere: what haze scatters forward minus what it scatters back, by the path's slope;
// fitted as slope / sqrt(level + steep slope^2).
const real kOnwardsLevel = 0.15;
const real kOnwardsSteep = 1.79;

// U Eq 3.1, corrected, with its three cases in one formula. Seen from below, a layer of air between two altitudes
// contributes the sky at its lower side minus the part of the sky above that passes through it; this is exact for any
// air. The path's layers are summed from the observer outwards.
//   sky:                       no object, one layer without an end
//   object with sky behind:    the layers' skies cancel except for the first and the last
//   object with ground behind: the zenith angle mirrored, with two corrections: sunlight scattered once
//                              at the true angle, and haze, which scatters mostly forward, lit from below
FUNCTION vec3 object_through_air(AirBetween air, vec3 object, real observer_m, real object_m, real length_m, real cos_sun,
                                 real cos_sun_zenith) {
  real low = min(observer_m, object_m);
  real high = max(observer_m, object_m);
  real s = max(length_m, 1.0);
  // Zenith angles at both ends of the path on a round Earth.
  real rise = min((high - low) / s, 1.0);
  real bend = s / (2.0 * kEarthRadius_m);
  real cos_low = clamp(rise - bend, -1.0, 1.0);
  real cos_high = clamp(rise + bend, -1.0, 1.0);
  real sun_low = held_cos_sun(cos_low, cos_sun, cos_sun_zenith);
  real sun_high = held_cos_sun(cos_high, cos_sun, cos_sun_zenith);
  vec3 lower_lit = lit_air(air.air, air.altitude_m.x, rise, cos_sun_zenith);
  vec3 higher_lit = lit_air(air.air, air.altitude_m.y, rise, cos_sun_zenith);
  vec3 lower_low = dome_sky_light(air.lower, cos_low, sun_low) / lower_lit;
  vec3 higher_low = dome_sky_light(air.higher, cos_low, sun_low) / higher_lit;
  vec3 lower_high = dome_sky_light(air.lower, cos_high, sun_high) / lower_lit;
  vec3 higher_high = dome_sky_light(air.higher, cos_high, sun_high) / higher_lit;

  const int slices = 3;
  real downwards = object_m < observer_m ? 1.0 : 0.0;
  vec2 once = downwards * (scattered_once(cos_sun) - scattered_once(0.5 * (sun_low + sun_high)));
  real onwards = downwards * kHazeAlbedo * rise / sqrt(kOnwardsLevel + kOnwardsSteep * rise * rise);
  real step_part = (1.0 - 2.0 * downwards) / real(slices);
  vec3 added = vec3(0.0);
  vec3 before = vec3(1.0);
  for (int i = 0; i < slices; ++i) {
    real near = downwards + real(i) * step_part;
    real under = min(near, near + step_part);
    real over = under + 1.0 / real(slices);
    real under_m = mix(low, high, under);
    real over_m = mix(low, high, over);
    real way_under = way_between_altitudes(under_m, air.altitude_m.x, air.altitude_m.y);
    real way_over = way_between_altitudes(over_m, air.altitude_m.x, air.altitude_m.y);
    vec3 path = air_along(under_m, over_m, s / real(slices));
    vec3 slice = transparency_of(air.air, path);
    vec3 sky_under = mix(mix(lower_low, lower_high, under), mix(higher_low, higher_high, under), way_under) *
                     lit_air(air.air, under_m, rise, cos_sun_zenith);
    vec3 sky_over = mix(mix(lower_low, lower_high, over), mix(higher_low, higher_high, over), way_over) *
                    lit_air(air.air, over_m, rise, cos_sun_zenith);
    vec3 haze = share_of_haze(air.air, path);
    real way = 0.5 * (way_under + way_over);
    vec3 unmirrored = mix(air.sun_lower, air.sun_higher, way) * mix(vec3(once.x), vec3(once.y), haze) +
                      onwards * haze * mix(air.below_lower, air.below_higher, way);
    added += before * (sky_under - slice * sky_over + (vec3(1.0) - slice) * unmirrored);
    before *= slice;
  }
  return path_transparency(air.air, low, high, s) * object + max(added, vec3(0.0));
}
