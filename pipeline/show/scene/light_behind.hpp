// What the camera sees where the object will be drawn, as a bound on the air's light before it. In fog the hill's pixels
// show the air alone, and that is seldom the light of the sky above it: fog is darker below, and before a dark hill.
#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "estimator/horizon/horizon.hpp"
#include "gles/scene.hpp"

namespace kasumi {

// The mean light around each point of a grid over `box`, over the horizon's at that azimuth, channel by channel. Where a
// mask covers all, kNoBound. Nothing: no box, no horizon, or a picture of another size.
constexpr double kNoBound = 10.0;
std::optional<AirlightGrid> light_behind(const Camera& scene, const PictureView& picture, const PixelBox& box,
                                         const HorizonLight& horizon);

// What is seen through air is the air's light, (1 - left) L, and whatever light comes through it: L is at most seen /
// (1 - left). `left`: the share of the light that the estimated air lets through. Since the estimate may be wrong, the
// air counts as so much thinner that only fog and thick haze bind.
glm::dvec3 most_airlight(const glm::dvec3& seen, const glm::dvec3& left);

}  // namespace kasumi
