// How good the scene camera's pictures are, in the renderer's words.
#pragma once

#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "calib/image_quality.hpp"
#include "gles/scene.hpp"

namespace kasumi {

// `layout`: what the camera's pictures are delivered in. `haze_blur_px`: what the air adds to the camera's point
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
