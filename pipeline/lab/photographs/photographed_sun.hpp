// The sun's place in a photograph of the sky: as given, as found in the picture, and whether both agree.
#pragma once

#include <optional>
#include <string>

#include "calib/camera.hpp"
#include "estimator/sky_camera/sun_in_image.hpp"

namespace kasumi {

// Where the top of a photograph that looks up points.
enum class Orientation {
  given,        // as the call or the calibration says
  assumed,      // to the north: not given, and not found in the picture
  from_sun,     // where the sun in the picture puts it
  from_series,  // where the suns of other pictures of the same camera put it
};
std::string_view name_of(Orientation orientation);  // "given", "assumed", "from the sun", "from other pictures"

struct SunGiven {
  std::optional<SunDirection> direction;  // azimuth clockwise from north
  std::string by;                         // how: "by time and place", "as given"
  bool from_picture = false;              // follow the picture, whatever is given
  bool orientation_known = false;         // false: the picture's top is taken for north until the sun is found
  Radians azimuth_up{};                   // of the camera
  bool unknown_camera = false;            // the sun is looked for by its shape, too
};

struct PhotographedSun {
  std::optional<SunDirection> direction;          // the sun's; azimuth clockwise from north as far as known
  SunDirection in_camera{0.0, 0.0, 1.0};          // the same in the directions of `camera`
  std::optional<SunBlob> seen;                    // in the picture, in the directions of `camera`
  std::optional<SunDirection> by_time_and_place;  // clockwise from north, also where the picture is followed
  std::optional<SunDirection> seen_at;            // the same, clockwise from north
  std::optional<Radians> disagreement;            // between both, with the orientation given or assumed at first
  Orientation orientation = Orientation::given;
  Radians azimuth_up{};          // that is followed
  std::string told;              // how the sun is known
  std::string orientation_told;  // empty: it was given, and is right
  std::string doubt;             // why an estimate may fail for the sun's sake; empty: for no such reason
};

double degrees_of_azimuth(Radians azimuth);  // 0 .. 360

// Looks for the sun in the picture, always. What is given is followed, since time and place are a thousand times more
// precise, unless `from_picture`. Where the camera's azimuth is not given, the observed sun determines it, if it stands
// as high as the one given.
PhotographedSun find_photographed_sun(const SkyPicture& picture, const Camera& camera, const SunGiven& given);

}  // namespace kasumi
