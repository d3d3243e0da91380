// A generated scene of known depth and air: 1 nm steps, its own sky, sun and air, as 8 bits of a camera with noise.
#pragma once

#include <cstdint>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "fixtures/illumination.hpp"
#include "fixtures/scene_geometry.hpp"
#include "fixtures/scene_view.hpp"
#include "fixtures/sensor.hpp"

namespace kasumi {

struct Scene {
  Camera camera;
  Image<Rgb8> picture;
  Image<glm::vec3> light;
  Image<float> distance_m;
  SunDirection sun;
  double altitude_m = 980.0;
  fixtures::SceneCameraOptions mounting{};
};

inline Scene scene_at(double turbidity, std::uint64_t seed) {
  fixtures::SceneCameraOptions options;
  options.width = 320;
  options.height = 180;
  options.field_of_view_deg = 20.0;
  options.pitch_deg = 1.0;
  const auto camera = fixtures::scene_camera(options);
  fixtures::Weather weather;
  weather.turbidity = turbidity;
  weather.sun = direction_from(from_degrees(50.0), from_degrees(230.0));
  weather.altitude_m = 980.0;
  const fixtures::Illumination illumination(weather);
  const auto geometry =
      fixtures::look_at_terrain(fixtures::Terrain(2), camera.camera, from_degrees(options.heading_deg));
  const auto light = fixtures::look_at_scene(illumination, camera.camera, geometry);
  auto exposure = fixtures::automatic_exposure(light, 0.97, 0.58);
  exposure.seed = seed;
  Scene scene{camera.camera, fixtures::expose(light, camera.camera, exposure), {}, {}, weather.sun};
  scene.mounting = options;
  scene.light = Image<glm::vec3>(options.width, options.height);
  scene.distance_m = Image<float>(options.width, options.height);
  for (int y = 0; y < options.height; ++y)
    for (int x = 0; x < options.width; ++x) {
      const glm::dvec3 encoded = glm::dvec3(scene.picture.at(x, y)) / 255.0;
      scene.light.at(x, y) = scene.camera.light_at({x, y}, encoded);
      // Where one ray of the pixel meets the sky, so does the pixel.
      double sum = 0.0;
      bool sky = false;
      for (int j = 0; j < fixtures::kRaysPerSide; ++j)
        for (int i = 0; i < fixtures::kRaysPerSide; ++i) {
          const auto range = geometry.points.at(x * fixtures::kRaysPerSide + i, y * fixtures::kRaysPerSide + j).range_m;
          sky = sky || !(range > 0.0F);
          sum += static_cast<double>(range);
        }
      scene.distance_m.at(x, y) =
          sky ? 0.0F : static_cast<float>(sum / (fixtures::kRaysPerSide * fixtures::kRaysPerSide));
    }
  return scene;
}

}  // namespace kasumi
