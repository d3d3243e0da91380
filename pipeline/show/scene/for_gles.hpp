// The interface from calibration and estimator to the renderer: copies numbers, and computes only what the renderer's
// own representation needs (grids, tables, steps).
#pragma once

#include <functional>

#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "calib/image_quality.hpp"
#include "estimator/air/attenuation.hpp"
#include "estimator/light/object_light.hpp"
#include "gles/scene.hpp"
#include "pipeline/site/config/installation.hpp"

namespace kasumi {

Haze haze_for_gles(const HazeCoefficients& haze, double observer_altitude_m, const FogLayer& fog = {});
ObjectLight light_for_gles(const LightOnObject& light);
ResponseCurve response_for_gles(const Response& response);
// Near and far enclose the object's sphere, so that the depth buffer's precision is spent on it (physics 7).
SceneView view_for_gles(const Camera& scene, const glm::dvec3& object_centre_m, double object_radius_m);

// Light from infinity on a grid over `box`. `light` is called with each point's pixel and world direction, or with the
// direction of the optical axis where the lens is undefined.
AirlightGrid airlight_grid(const Camera& scene, const PixelBox& box,
                           const std::function<glm::dvec3(const glm::dvec2& pixel, const Direction&)>& light);

// The scene camera's image quality. `layout`: of its pictures. `haze_blur_px`: what the air adds to the camera's point
// spread. Their sum is rounded to quarters of a pixel, so that small changes of the air do not recompile shaders.
ObjectDetail detail_for_gles(const ImageQuality& quality, PixelLayout layout, double haze_blur_px = 0.0);
// The variance of light L in the camera's full scale, behind an analogue gain g and a channel's white balance gain w,
// E electrons at gain 1: (g w / E) L + (g w r / E)^2. `frame`: the frame's number, which makes the noise differ between
// frames.
SensorNoise noise_for_gles(const ImageQuality& quality, const glm::dvec3& white_balance, double gain,
                           std::uint32_t frame);
// From distances along each pixel's line of sight to depths along the optical axis. 0 stays 0.
Image<float> depth_for_gles(const Camera& scene, const Image<float>& distances_m);

}  // namespace kasumi
