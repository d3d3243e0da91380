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

// What the lens scatters of the sun around it: a tenth of what an eye does by the CIE's general disability glare equation
// (CIE 146, 10 / angle^3 + 5 / angle^2 in degrees, per steradian). chord: length of the difference of the two directions.
const real kLensOfEye = 0.1;
const real kSunDisc_sr = 6.797e-5;
const real kSunRadius_deg = 0.2665;
const real kDegrees = 57.295780;
FUNCTION vec3 sun_glare(vec3 mean_luminance, real chord) {
  real inverse = 1.0 / max(kDegrees * chord, kSunRadius_deg);
  return mean_luminance * (kSunDisc_sr * kLensOfEye * inverse * inverse * (10.0 * inverse + 5.0));
}

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

// How haze scatters: the share of what it takes from light that it scatters, and two Henyey-Greenstein lobes, forwards
// and backwards. Because lobes are normalised to 1 towards the sun, a lobe's height is its share times
// (1 + g) / (1 - g)^2, with g its asymmetry.
struct HazeScattering {
  vec3 albedo;
  vec2 asymmetry;
  vec2 height;
};

// The light that a path through the air adds, from the skies of a lower and a higher altitude that bracket it.
struct AirBetween {
  DomeSky lower;
  DomeSky higher;
  vec2 altitude_m;  // of the two
  PathAir air;
  HazeScattering haze;
  vec3 sun_lower;  // on a plane facing it, lux
  vec3 sun_higher;
  vec3 departures[4];  // see departure
  vec3 departures_sun[4];
  vec3 below[3];  // see parabola; at the lower altitude, half the way and at the higher
  vec3 below_steep[3];
};

// A view downwards may have an angle to the sun that no view above the horizon has at the mirrored zenith angle; takes
// the nearest possible one.
FUNCTION real held_cos_sun(real cos_zenith, real cos_sun, real cos_sun_zenith) {
  real across = sqrt(max((1.0 - cos_zenith * cos_zenith) * (1.0 - cos_sun_zenith * cos_sun_zenith), 0.0));
  real middle = cos_zenith * cos_sun_zenith;
  return clamp(cos_sun, middle - across, middle + across);
}

// The share per steradian of the sunlight lost on the path that is singly scattered towards the eye: by molecules
// (Rayleigh) and by haze that absorbs nothing.
const real kInverseFourPi = 0.0795775;
FUNCTION vec2 scattered_once(HazeScattering haze, real cos_sun) {
  real lobes = haze.height.x * dome_lobe(haze.asymmetry.x, cos_sun) + haze.height.y * dome_lobe(haze.asymmetry.y, cos_sun);
  return kInverseFourPi * vec2(0.75 * (1.0 + cos_sun * cos_sun), lobes);
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

// What skies on the way differ from interpolated ones, as a share: it is known at a third and at two thirds of the way,
// each at two elevations; departures holds low and high at the first, then at the second. departures_sun is more of it,
// around the sun. Halfway between two altitudes hazy skies are up to a fifth darker, around the sun half again as bright.
const vec2 kDepartureWays = vec2(0.33333333, 0.66666667);
const vec2 kDepartureSines = vec2(0.08, 0.4);
const real kAroundSun = 0.5;  // asymmetry of a lobe
FUNCTION real departure_elevation(real cos_zenith) { return 1.0 / (1.0 + 6.0 * cos_zenith); }
FUNCTION vec3 departure(vec3 first, vec3 second, real way) {
  return 4.5 * way * (1.0 - way) * ((2.0 - 3.0 * way) * first + (3.0 * way - 1.0) * second);
}

// The sky at an altitude, from those of the two that bracket it over lit_air.
FUNCTION vec3 sky_on_the_way(PathAir air, vec3 lower, vec3 higher, vec3 first, vec3 second, real altitude_m, real way,
                             real cos_zenith, real cos_sun_zenith) {
  return mix(lower, higher, way) * (vec3(1.0) + departure(first, second, way)) *
         lit_air(air, altitude_m, cos_zenith, cos_sun_zenith);
}

// For light uniform over each half of the sphere: what haze scatters onwards less what it scatters back, by the path's
// slope; fitted as slope / sqrt(level + steep slope^2).
const real kOnwardsLevel = 0.15;
const real kOnwardsSteep = 1.79;
FUNCTION real onwards_share(real slope) { return slope / sqrt(kOnwardsLevel + kOnwardsSteep * slope * slope); }

// Light scattered more than once that haze sends to an eye above it, less what it sends to one below at the mirrored
// angle, is onwards_share * (below + slope * below_steep); over the way a parabola.
FUNCTION vec3 parabola(vec3 lower, vec3 halfway, vec3 higher, real way) {
  return mix(lower, higher, way) + 4.0 * way * (1.0 - way) * (halfway - 0.5 * (lower + higher));
}

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
  real elevation = (departure_elevation(rise) - departure_elevation(kDepartureSines.x)) /
                   (departure_elevation(kDepartureSines.y) - departure_elevation(kDepartureSines.x));
  real around_sun = dome_lobe(kAroundSun, 0.5 * (sun_low + sun_high));
  vec3 first = mix(air.departures[0] + around_sun * air.departures_sun[0],
                   air.departures[1] + around_sun * air.departures_sun[1], elevation);
  vec3 second = mix(air.departures[2] + around_sun * air.departures_sun[2],
                    air.departures[3] + around_sun * air.departures_sun[3], elevation);

  const int slices = 3;
  real downwards = object_m < observer_m ? 1.0 : 0.0;
  vec2 once = downwards * (scattered_once(air.haze, cos_sun) - scattered_once(air.haze, 0.5 * (sun_low + sun_high)));
  real onwards = downwards * onwards_share(rise);
  vec3 below_lower = onwards * (air.below[0] + rise * air.below_steep[0]);
  vec3 below_halfway = onwards * (air.below[1] + rise * air.below_steep[1]);
  vec3 below_higher = onwards * (air.below[2] + rise * air.below_steep[2]);
  vec3 added = vec3(0.0);
  vec3 before = vec3(1.0);
  real near_way = way_between_altitudes(observer_m, air.altitude_m.x, air.altitude_m.y);
  vec3 near_sky = sky_on_the_way(air.air, mix(lower_low, lower_high, downwards), mix(higher_low, higher_high, downwards), first,
                                 second, observer_m, near_way, rise, cos_sun_zenith);
  for (int i = 0; i < slices; ++i) {
    real from = real(i) / real(slices);
    real to = real(i + 1) / real(slices);
    real near_m = mix(observer_m, object_m, from);
    real far_m = mix(observer_m, object_m, to);
    real far_share = mix(to, 1.0 - to, downwards);  // of the way up
    real far_way = way_between_altitudes(far_m, air.altitude_m.x, air.altitude_m.y);
    vec3 far_sky = sky_on_the_way(air.air, mix(lower_low, lower_high, far_share), mix(higher_low, higher_high, far_share), first,
                                  second, far_m, far_way, rise, cos_sun_zenith);
    vec3 path = air_along(near_m, far_m, s / real(slices));
    vec3 slice = transparency_of(air.air, path);
    vec3 haze = share_of_haze(air.air, path);
    real way = 0.5 * (near_way + far_way);
    vec3 unmirrored = mix(air.sun_lower, air.sun_higher, way) * mix(vec3(once.x), once.y * air.haze.albedo, haze) +
                      air.haze.albedo * haze * parabola(below_lower, below_halfway, below_higher, way);
    vec3 mirrored = mix(near_sky - slice * far_sky, far_sky - slice * near_sky, downwards);
    added += before * (mirrored + (vec3(1.0) - slice) * unmirrored);
    before *= slice;
    near_way = far_way;
    near_sky = far_sky;
  }
  return path_transparency(air.air, low, high, s) * object + max(added, vec3(0.0));
}
