#include "estimator/sky_camera/sun_by_shape.hpp"

#include <algorithm>
#include <cmath>

#include "base/square.hpp"
#include "estimator/sky_camera/bright_blobs.hpp"

namespace kasumi {

namespace {

// The usual shift of a blob by a clear sky's brightening towards the horizon, where it was not measured.
Radians usually_lowered(const BrightBlob& blob) {
  // The sky's slope over the fall of the sun's surroundings; a middle stays within its blob.
  constexpr double kSlopeOverFall = 3.0, kMostOfRadius = 0.8;
  const double cosine = std::max(blob.direction.z, 0.0), sine = std::sqrt(1.0 - square(std::min(cosine, 1.0)));
  const double moved = kSlopeOverFall * sine / (cosine + 0.1) * square(blob.radius.value);
  return Radians{std::min(moved, kMostOfRadius * blob.radius.value)};
}

// Large blobs are cut off by clouds and the horizon, and the sky is brighter on one side of them.
Radians sigma_of(const BrightBlob& blob) {
  // Shares of sigma: of the radius, of the levels' scatter, of what the sky around moved it by.
  constexpr double kOfRadius = 0.12, kOfScatter = 0.3, kOfLowered = 0.4;
  // The sun's own radius is .27 deg; blobs larger than 10 deg are cut off and count in proportion.
  constexpr Radians kLeast = from_degrees(0.2), kLarge = from_degrees(10.0);
  const double larger = std::max(1.0, blob.radius.value / kLarge.value);
  const double lowered = blob.lowered ? kOfLowered * blob.lowered->value : usually_lowered(blob).value;
  return Radians{std::sqrt(square(kLeast.value) + square(kOfRadius * larger * blob.radius.value) +
                           square(kOfScatter * blob.scatter.value) + square(lowered))};
}

// The middle where the sky around does not move it.
SunDirection raised(const BrightBlob& blob) {
  const Radians zenith = zenith_angle(blob.direction);
  return direction_from(Radians{std::max(0.0, (zenith - blob.lowered.value_or(Radians{0.0})).value)},
                        azimuth_angle(blob.direction));
}

// The logarithm of the odds that a blob is the sun: large, most of what is as bright, alike on all sides (a cloud
// has sky on one side), in a sky that is much darker, without a rival, and not low. Factors by logistic regression on
// strangers' pictures of seven cameras, varied in size, exposure and crop, and on generated ones; each camera weighs
// alike. No sign is followed beyond where most pictures lie: a sky that is darker than a third of the sun's level is no
// better than that.
double log_odds(const BrightBlob& blob, const BrightBlobs& sky) {
  // The radius of the largest other blob. Reflections, ghosts and water drops lie in darker surroundings than the sun.
  constexpr double kAsBrightAround = 0.8;
  double rival = 0.0;
  for (const BrightBlob& other : sky.blobs)
    if (&other != &blob && other.around >= kAsBrightAround * blob.around) rival = std::max(rival, other.radius.value);
  const double over_5_deg = std::log(std::max(to_degrees(blob.radius), 2.0) / 5.0);
  const double cell = blob.resolution.value;
  double sum = 10.85;
  sum -= 0.40 * std::max(over_5_deg, 0.0) + 2.93 * std::max(-over_5_deg, 0.0);
  sum += 1.85 * std::log(std::clamp(blob.share, 0.02, 0.6));
  sum -= 11.29 * blob.spread;
  sum -= 15.92 * std::clamp(sky.middle, 0.3, 1.0);
  sum -= std::log(std::max((rival + cell) / (blob.radius.value + cell), 0.2));
  sum -= 42.5 * std::max(0.2 - blob.direction.z, 0.0);
  return sum;
}

}  // namespace

std::optional<SunBlob> sun_by_shape(const SkyPicture& picture, const Camera& camera, const SunBlobLimits& options) {
  const BrightBlobs sky = bright_sky(picture, camera, options.saturated);
  SunBlob best;
  for (const BrightBlob& blob : sky.blobs) {
    if (blob.radius > options.largest_radius) continue;
    const Radians sigma = sigma_of(blob);
    const SunDirection at = raised(blob);
    double confidence = 1.0 / (1.0 + std::exp(-log_odds(blob, sky)));
    if (options.expected) confidence = confidence_where_expected(confidence, at, sigma, *options.expected);
    if (confidence > best.confidence) best = {at, {}, blob.radius, confidence, sigma};
  }
  if (best.confidence < options.least_by_shape || best.sigma > options.largest_by_shape) return std::nullopt;
  const auto pixel = camera.pixel_of(best.direction);
  if (!pixel) return std::nullopt;
  best.pixel = *pixel;
  return best;
}

}  // namespace kasumi
