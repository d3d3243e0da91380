#include "tests/estimator/cloud_cover/drawn_skies.hpp"

#include <cmath>
#include <random>

#include <glm/common.hpp>

namespace kasumi {

Camera camera_looking_up() {
  Camera camera;
  camera.name = "sky";
  camera.width = camera.height = 300;
  const double half = from_degrees(90.0).value;
  camera.lens = equidistant_lens({149.5, 149.5}, 145.0 / half, {half});
  camera.to_world = camera_to_world(from_degrees(180), from_degrees(90), {0});
  return camera;
}

SkyPicture drawn(const DrawnSky& sky, const Camera& camera) {
  std::mt19937 random(7);
  std::normal_distribution<float> noise(0.0f, 0.004f);
  Image<glm::vec3> encoded(camera.width, camera.height);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const auto direction = camera.direction_at({x, y});
      if (!direction) continue;
      const glm::vec3 seen = sky(to_degrees(zenith_angle(*direction)), to_degrees(azimuth_angle(*direction)));
      if (seen == glm::vec3(0.0f)) continue;
      encoded.at(x, y) = glm::clamp(seen + glm::vec3(noise(random), noise(random), noise(random)), 0.0f, 1.0f);
    }
  return *sky_picture(encoded, 1.0 / 255.0, camera);
}

SunDirection drawn_sun() {
  return direction_from(from_degrees(50.0), from_degrees(120.0));
}

glm::vec3 clear_sky(double zenith_deg, double azimuth_deg) {
  const Direction direction = direction_from(from_degrees(zenith_deg), from_degrees(azimuth_deg));
  const double sun_deg = to_degrees(angle_between(direction, drawn_sun()));
  const auto low = static_cast<float>(std::pow(zenith_deg / 90.0, 6));
  const auto near_sun = static_cast<float>(std::exp(-sun_deg / 14.0));
  const glm::vec3 blue(0.36f, 0.50f, 0.68f), white(0.80f, 0.83f, 0.86f), sun(1.3f);
  return glm::mix(glm::mix(blue, white, 0.7f * low), sun, near_sun);
}

glm::vec3 cloud(double zenith_deg, double azimuth_deg) {
  const double a = azimuth_deg / 57.29578;
  const double x = zenith_deg * std::sin(a), y = zenith_deg * std::cos(a);
  const auto wave = static_cast<float>(0.5 * std::sin(x / 7.0) * std::cos(y / 9.0) + 0.3 * std::sin((x + y) / 3.0));
  return glm::vec3(0.66f, 0.67f, 0.70f) * (1.0f + 0.2f * wave);
}

}  // namespace kasumi
