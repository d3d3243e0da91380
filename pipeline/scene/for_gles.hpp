// The wall between what calibration and estimator say and what the renderer is told: numbers are copied, and nothing is
// computed that is not of the renderer's making (grids, tables, steps).
#pragma once

#include <functional>

#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "calib/image_quality.hpp"
#include "estimator/air/attenuation.hpp"
#include "estimator/light/object_light.hpp"
#include "gles/scene.hpp"
#include "pipeline/config/installation.hpp"

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

// How good the scene camera's pictures are. // `layout`: what the camera's pictures are delivered in. `haze_blur_px`: what the air adds to the camera's point
// spread; both together go in steps of a quarter of a pixel, so that shaders are not made anew with every breath of
// air.
ObjectDetail detail_for_gles(const ImageQuality& quality, PixelLayout layout, double haze_blur_px = 0.0);
// The variance of light L in the camera's full scale, behind an analogue gain g and a channel's white balance gain w,
// E electrons at gain 1: (g w / E) L + (g w r / E)^2. `frame`: its number, so that every frame has noise of its own.
SensorNoise noise_for_gles(const ImageQuality& quality, const glm::dvec3& white_balance, double gain,
                           std::uint32_t frame);
// From distances along each pixel's line of sight to depths along the optical axis. 0 stays 0.
Image<float> depth_for_gles(const Camera& scene, const Image<float>& distances_m);

}  // namespace kasumi
