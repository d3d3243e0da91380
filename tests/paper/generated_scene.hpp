// A generated scene of known depth and air: 1 nm steps, its own sky, sun and air, as 8 bits of a camera with noise.
#pragma once

#include <cstdint>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "estimator/atmosphere.hpp"
#include "fixtures/landscape/scene_geometry.hpp"
#include "fixtures/landscape/scene_view.hpp"
#include "fixtures/light/illumination.hpp"
#include "fixtures/light/sensor.hpp"

namespace kasumi {

struct Scene {
  Camera camera;
  Image<Rgb8> picture;
  Image<glm::vec3> light;
  Image<float> distance_m;
  SunDirection sun;
  double altitude_m = 980.0;
  fixtures::PinholeSpec mounting{};
};

// Place and time; the first is the one behind all figures of docs/photographs.md.
struct Place {
  std::uint64_t terrain = 2;
  double sun_zenith_deg = 50.0, sun_azimuth_deg = 230.0;
  double field_of_view_deg = 20.0, pitch_deg = 1.0;
  int width = 320, height = 180;
};

// The land as the camera sees it, independent of the air; the slowest part.
struct Land {
  Place place;
  fixtures::PinholeSpec options;
  fixtures::PinholeCamera camera;
  fixtures::SceneGeometry geometry;
};
inline Land land_at(const Place& place) {
  fixtures::PinholeSpec options;
  options.width = place.width;
  options.height = place.height;
  options.field_of_view_deg = place.field_of_view_deg;
  options.pitch_deg = place.pitch_deg;
  auto camera = fixtures::scene_camera(options);
  auto geometry =
      fixtures::look_at_terrain(fixtures::Terrain(place.terrain), camera.camera, from_degrees(options.heading_deg));
  return {place, options, std::move(camera), std::move(geometry)};
}

// `seed`: for the camera's noise.
inline Scene scene_at(const Land& land, double turbidity, std::uint64_t seed) {
  const auto& camera = land.camera;
  const int width = land.options.width, height = land.options.height;
  fixtures::Weather weather;
  weather.turbidity = turbidity;
  weather.sun = direction_from(from_degrees(land.place.sun_zenith_deg), from_degrees(land.place.sun_azimuth_deg));
  weather.altitude_m = 980.0;
  const fixtures::Illumination illumination(weather);
  const auto light = fixtures::look_at_scene(illumination, camera.camera, land.geometry);
  auto exposure = fixtures::automatic_exposure(light, 0.97, 0.58);
  exposure.seed = seed;
  Scene scene{camera.camera, fixtures::expose(light, camera.camera, exposure), {}, {}, weather.sun};
  scene.mounting = land.options;
  scene.light = Image<glm::vec3>(width, height);
  scene.distance_m = Image<float>(width, height);
  constexpr int kRays = fixtures::kRaysPerSide;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const glm::dvec3 encoded = glm::dvec3(scene.picture.at(x, y)) / 255.0;
      scene.light.at(x, y) = scene.camera.light_at({x, y}, encoded);
      // Averaged over the rays that hit land: a mixed pixel counts as land.
      double sum = 0.0;
      int hits = 0;
      for (int j = 0; j < kRays; ++j)
        for (int i = 0; i < kRays; ++i) {
          const auto range = land.geometry.points.at(x * kRays + i, y * kRays + j).range_m;
          hits += range > 0.0F;
          sum += static_cast<double>(range);
        }
      scene.distance_m.at(x, y) = hits == 0 ? 0.0F : static_cast<float>(sum / hits);
    }
  return scene;
}
}  // namespace kasumi
