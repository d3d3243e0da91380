// The wall between the estimator's words and the renderer's: numbers are copied, nothing is computed but the grids.
#pragma once

#include <functional>

#include "calib/camera.hpp"
#include "estimator/attenuation.hpp"
#include "estimator/object_light.hpp"
#include "gles/scene.hpp"
#include "pipeline/installation.hpp"

namespace kasumi {

Haze haze_for_gles(const HazeCoefficients& haze, double observer_altitude_m, const FogLayer& fog = {});
ObjectLight light_for_gles(const LightOnObject& light);
ResponseCurve response_for_gles(const Response& response);
// Near and far enclose the object's sphere, so that the depth buffer's precision is spent on it (physics 7).
SceneView view_for_gles(const Camera& scene, const glm::dvec3& object_centre_m, double object_radius_m);

// Light from infinity on a grid over `box`. `light` is asked with each point's pixel and world direction; where the
// lens does not reach, the direction of the optical axis.
AirlightGrid airlight_grid(const Camera& scene, const PixelBox& box,
                           const std::function<glm::dvec3(const glm::dvec2& pixel, const Direction&)>& light);

}  // namespace kasumi
