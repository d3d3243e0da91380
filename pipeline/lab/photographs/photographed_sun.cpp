#include "pipeline/lab/photographs/photographed_sun.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace kasumi {
namespace {

constexpr Radians kAgree = from_degrees(3.0);

// Apart by no more than what the picture is sure of, and than what lenses are known to.
bool near(Radians apart, const SunBlob& seen) {
  return apart.value <= std::max(kAgree.value, 3.0 * seen.sigma.value);
}

SunDirection turned(const SunDirection& direction, Radians by) {
  return direction_from(zenith_angle(direction), azimuth_angle(direction) + by);
}

// Whatever is seen where the sun stands as high as it should is the likelier to be it.
std::optional<SunBlob> find_sun_as_high(const SkyPicture& picture, const Camera& camera, const SunGiven& given) {
  const SunDirection& sun = *given.direction;
  const auto seen =
      find_sun(picture, camera,
               {.by_shape = given.unknown_camera, .expected = ExpectedSun{.direction = sun, .azimuth_known = false}});
  const bool as_high = seen && std::abs(zenith_angle(seen->direction).value - zenith_angle(sun).value) <= kAgree.value;
  return as_high ? seen : std::nullopt;
}

// The camera's azimuth was not given.
void turn_by_sun(const SunGiven& given, PhotographedSun& sun) {
  sun.orientation = Orientation::assumed;
  sun.orientation_told = "--azimuth-up-deg is not given: 0 was assumed";
  if (!sun.seen) {
    sun.orientation_told += ", and no sun is seen in the picture to correct it";
    sun.doubt =
        "the picture's orientation is not known (--azimuth-up-deg 0 was assumed, and the picture shows no sun to "
        "determine it)";
    return;
  }
  if (near(*sun.disagreement, *sun.seen)) {
    sun.orientation_told +=
        fmt::format(", and the sun in the picture agrees within {:.1f} deg", to_degrees(*sun.disagreement));
    return;
  }
  const Radians up = azimuth_angle(*given.direction) - azimuth_angle(sun.seen->direction);
  const Radians left = angle_between(turned(sun.seen->direction, up), *given.direction);
  const auto apart =
      fmt::format("the sun in the picture is {:.1f} deg from where that puts it", to_degrees(*sun.disagreement));
  if (near(left, *sun.seen)) {
    sun.orientation = Orientation::from_sun;
    sun.azimuth_up = up;
    sun.in_camera = turned(*given.direction, -1.0 * up);
    sun.seen_at = turned(sun.seen->direction, up);
    sun.orientation_told += fmt::format(", but {}; with {:.1f}, which was followed, they are {:.1f} deg apart", apart,
                                        degrees_of_azimuth(up), to_degrees(left));
    return;
  }
  sun.orientation_told += fmt::format(", but {}", apart);
  sun.doubt = fmt::format(
      "{}, and it is seen {:.1f} deg from the zenith in place of {:.1f}: check time, place and lens, and give "
      "--azimuth-up-deg",
      apart, to_degrees(zenith_angle(sun.seen->direction)), to_degrees(zenith_angle(*given.direction)));
}

}  // namespace

double degrees_of_azimuth(Radians azimuth) {
  const double degrees = std::fmod(to_degrees(azimuth), 360.0);
  return degrees < 0.0 ? degrees + 360.0 : degrees;
}

std::string_view name_of(Orientation orientation) {
  switch (orientation) {
    case Orientation::given: return "given";
    case Orientation::assumed: return "assumed";
    case Orientation::from_sun: return "from the sun";
    case Orientation::from_series: return "from other pictures";
  }
  return "";
}

PhotographedSun find_photographed_sun(const SkyPicture& picture, const Camera& camera, const SunGiven& given) {
  PhotographedSun sun;
  sun.azimuth_up = given.azimuth_up;
  sun.by_time_and_place = given.direction;
  sun.seen = find_sun(picture, camera, {.by_shape = given.unknown_camera});
  const bool turnable = given.direction && !given.orientation_known;
  if (!sun.seen && turnable) sun.seen = find_sun_as_high(picture, camera, given);
  if (sun.seen) sun.seen_at = sun.seen->direction;
  if (sun.seen && given.direction) sun.disagreement = angle_between(*given.direction, sun.seen->direction);

  if (given.from_picture || !given.direction) {
    if (!sun.seen) {
      sun.told = "no sun is seen in the image";
      return sun;
    }
    sun.direction = sun.in_camera = sun.seen->direction;
    sun.told = fmt::format("seen in the image, {}", how_sure(*sun.seen));
    if (sun.disagreement) sun.told += fmt::format(", {:.1f} deg from the ephemeris", to_degrees(*sun.disagreement));
    return sun;
  }

  sun.direction = sun.in_camera = *given.direction;
  if (turnable) {
    turn_by_sun(given, sun);
  } else if (sun.seen && !near(*sun.disagreement, *sun.seen)) {
    sun.doubt = fmt::format(
        "the sun is seen {:.1f} deg from where time, place and orientation put it: check them (--azimuth-up-deg, or "
        "[sky] of the calibration)",
        to_degrees(*sun.disagreement));
    sun.orientation_told = sun.doubt;
  }
  sun.told =
      given.by + (sun.seen ? fmt::format("; in the image {:.1f} deg from there, {}",
                                         to_degrees(angle_between(*sun.direction, *sun.seen_at)), how_sure(*sun.seen))
                           : std::string("; no sun is seen in the image"));
  return sun;
}

}  // namespace kasumi
