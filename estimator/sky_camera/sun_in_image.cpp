#include "estimator/sky_camera/sun_in_image.hpp"

#include <fmt/format.h>

#include "estimator/sky_camera/sun_by_aureole.hpp"
#include "estimator/sky_camera/sun_by_shape.hpp"

namespace kasumi {

std::optional<SunBlob> find_sun(const SkyPicture& picture, const Camera& camera, const SunBlobLimits& options) {
  if (picture.encoded.empty()) return std::nullopt;
  const auto by_aureole = sun_by_aureole(picture, camera, options);
  return by_aureole || !options.by_shape ? by_aureole : sun_by_shape(picture, camera, options);
}

std::string how_sure(const SunBlob& blob) {
  return fmt::format("+- {:.1f} deg, {:.0f} % sure", to_degrees(blob.sigma), 100.0 * blob.confidence);
}

SunCheck cross_check(const std::optional<SunDirection>& ephemeris, const std::optional<SunBlob>& blob,
                     bool clock_trusted, bool looked, Radians tolerance) {
  SunCheck check;
  if (ephemeris && blob) {
    check.disagreement = angle_between(*ephemeris, blob->direction);
    check.agrees = *check.disagreement <= tolerance;
  }
  if (ephemeris && clock_trusted) {
    check.source = SunSource::ephemeris;
    check.direction = *ephemeris;
  } else if (blob) {
    check.source = SunSource::image;
    check.direction = blob->direction;
  }
  const std::string apart =
      check.disagreement ? fmt::format("the sun in the image is {:.1f} deg from the ephemeris ({})",
                                       to_degrees(*check.disagreement), how_sure(*blob))
      : blob             ? fmt::format("seen in the image ({}), there is no ephemeris to compare with", how_sure(*blob))
      : looked           ? std::string("no sun is seen in the image")
                         : std::string("there is no image to look for the sun in");
  switch (check.source) {
    case SunSource::ephemeris:
      check.message = check.disagreement && !check.agrees
                          ? apart + "; the clock is trusted, so check the camera's orientation"
                          : apart;
      break;
    case SunSource::image:
      check.message = apart + (clock_trusted ? "" : "; the clock is not trusted, so the sun in the image is used");
      break;
    case SunSource::none:
      check.message = apart + ", and the clock is not trusted: the sun's direction is unknown";
      break;
  }
  return check;
}

}  // namespace kasumi
