// Drawn fisheye pictures of skies, for kinds of sky and of camera.
#pragma once

#include <functional>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "estimator/turbidity/sky_picture.hpp"

namespace kasumi {

// A camera that looks up: 300 x 300, horizon at radius 145.
Camera camera_looking_up();

// What is seen at a zenith angle and azimuth in degrees; the noise of a camera is added to it.
using DrawnSky = std::function<glm::vec3(double zenith_deg, double azimuth_deg)>;
SkyPicture drawn(const DrawnSky& sky, const Camera& camera);

// Blue, white at the horizon, with a white glow around a sun at zenith 50 deg, azimuth 120 deg.
glm::vec3 clear_sky(double zenith_deg, double azimuth_deg);
SunDirection drawn_sun();
// Grey with some structure.
glm::vec3 cloud(double zenith_deg, double azimuth_deg);

}  // namespace kasumi
