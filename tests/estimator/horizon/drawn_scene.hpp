// Synthetic scenes for the horizon's tests: a sky of known light over ground, hills and towers.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "estimator/horizon/horizon.hpp"

namespace kasumi {

inline Camera drawn_camera(double pitch_deg = 4.0) {
  Camera camera;
  camera.name = "scene";
  camera.width = 640;
  camera.height = 360;
  PinholeParameters pinhole;
  pinhole.focal_px = {700.0, 700.0};
  pinhole.centre = {319.5, 179.5};
  camera.lens = pinhole_lens(pinhole);
  camera.to_world = camera_to_world(from_degrees(20.0), from_degrees(pitch_deg), {0.0});
  camera.vignetting.radius_px = 400.0;
  camera.vignetting.centre = {319.5, 179.5};
  return camera;
}

// Brightest at the horizon, brighter and yellower to the east.
inline glm::dvec3 drawn_sky(const Direction& direction) {
  const double rise = std::exp(-6.0 * std::max(0.0, direction.z));
  const double east = 1.0 + 0.25 * direction.x;
  return east * (glm::dvec3{0.12, 0.19, 0.36} + rise * glm::dvec3{0.36, 0.36, 0.30});
}

struct DrawnScene {
  Image<Rgb8> picture;
  Image<std::uint8_t> sky;  // truth
};

struct DrawnOptions {
  double noise = 0.0;  // of encoded values, 0..255
  // Light of an object in front of the sky at a pixel; a negative red means sky.
  std::function<glm::dvec3(int, int)> front = [](int, int) { return glm::dvec3{-1.0}; };
  std::function<glm::dvec3(const Direction&)> sky = drawn_sky;
};

// Green and textured: blotches of several sizes.
inline glm::dvec3 drawn_ground(int x, int y) {
  const double blotches =
      std::sin(0.9 * x + 0.3 * y) * std::sin(0.7 * y - 0.2 * x) + std::sin(0.21 * x) * std::sin(0.33 * y);
  return glm::dvec3{0.06, 0.09, 0.03} * (1.0 + 0.4 * blotches);
}

inline DrawnScene draw(const Camera& camera, const DrawnOptions& options) {
  DrawnScene scene{Image<Rgb8>(camera.width, camera.height), Image<std::uint8_t>(camera.width, camera.height)};
  std::mt19937_64 random(7);
  const auto gaussian = [&] {  // sum of uniforms, to be the same on every machine
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += static_cast<double>(random() >> 11) * 0x1p-53;
    return sum;
  };
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      const Direction direction = *camera.direction_at({x, y});
      glm::dvec3 light = options.front(x, y);
      if (light.x < 0.0) {
        if (direction.z > 0.0) {
          light = options.sky(direction);
          scene.sky.at(x, y) = 255;
        } else {
          light = drawn_ground(x, y);
        }
      }
      const glm::dvec3 encoded = 255.0 * camera.response.to_encoded(glm::clamp(light, 0.0, 1.0));
      for (int c = 0; c < 3; ++c) {
        scene.picture.at(x, y)[c] =
            static_cast<std::uint8_t>(std::lround(std::clamp(encoded[c] + options.noise * gaussian(), 0.0, 255.0)));
      }
    }
  }
  return scene;
}

// Largest relative error of the measured light against the synthetic sky in the same direction.
inline double worst_light_error(const HorizonLight& horizon) {
  double worst = 0.0;
  for (const HorizonColumn& column : horizon.columns) {
    const glm::dvec3 truth = drawn_sky(direction_from(column.zenith, column.azimuth));
    for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(column.light[c] / truth[c] - 1.0));
  }
  return worst;
}

}  // namespace kasumi
