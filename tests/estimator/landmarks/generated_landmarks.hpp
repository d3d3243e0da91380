// A generated scene seen through haze, with boxes on its ridges whose distance is known from the geometry.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "estimator/landmarks/channel_extinctions.hpp"
#include "fixtures/landscape/scene_geometry.hpp"
#include "fixtures/landscape/scene_view.hpp"
#include "fixtures/light/air.hpp"
#include "fixtures/light/illumination.hpp"
#include "fixtures/light/sensor.hpp"

namespace kasumi {

constexpr double kValley_m = 400.0;  // the camera's altitude

struct GeneratedView {
  fixtures::PinholeCamera camera;
  fixtures::SceneGeometry geometry;
  std::vector<ContrastLandmark> landmarks;
};

// Boxes at one distance each (within 8 %): the most level ones per octave of distance, on the left and on the right,
// chosen by geometry alone.
inline std::vector<ContrastLandmark> landmarks_on(const fixtures::SceneGeometry& geometry, int width, int height) {
  constexpr int kWide = 10, kHigh = 3, kRays = fixtures::kRaysPerSide;
  struct Found {
    double off = 1e9;
    ContrastLandmark landmark;
  };
  std::vector<Found> best(2 * 6);
  for (int y = 0; y + kHigh <= height; ++y)
    for (int x = 0; x + kWide <= width; x += 2) {
      double nearest = 1e9, farthest = 0.0, sum = 0.0, up = 0.0;
      for (int j = y * kRays; j < (y + kHigh) * kRays; ++j)
        for (int i = x * kRays; i < (x + kWide) * kRays; ++i) {
          const auto& point = geometry.points.at(i, j);
          const auto range = static_cast<double>(point.range_m);
          nearest = std::min(nearest, range);
          farthest = std::max(farthest, range);
          sum += range;
          up += static_cast<double>(point.up_m);
        }
      const double rays = kWide * kHigh * kRays * kRays, mean = sum / rays;
      if (!(nearest > 0.0) || farthest - nearest > 0.08 * mean) continue;
      const auto octave = static_cast<int>(std::floor(std::log2(mean / 750.0)));
      if (octave < 0 || octave > 5) continue;
      auto& found = best[static_cast<std::size_t>(2 * octave + (x < width / 2 ? 0 : 1))];
      const double off = std::abs(up / rays / mean);
      if (off >= found.off) continue;
      found.off = off;
      found.landmark = {};
      found.landmark.name = std::to_string(static_cast<int>(mean)) + " m";
      found.landmark.distance_m = mean;
      found.landmark.rise_m = up / rays;
      found.landmark.surface = {x, y, kWide, kHigh};
    }
  std::vector<ContrastLandmark> landmarks;
  for (const auto& found : best)
    if (found.off < 0.05) landmarks.push_back(found.landmark);
  return landmarks;
}

inline GeneratedView generated_view(std::uint64_t terrain, double heading_deg = 4.0) {
  fixtures::PinholeSpec options;
  options.heading_deg = heading_deg;
  options.width = 320;
  options.height = 180;
  options.field_of_view_deg = 20.0;
  options.pitch_deg = 1.0;
  GeneratedView view;
  view.camera = fixtures::scene_camera(options);
  view.geometry =
      fixtures::look_at_terrain(fixtures::Terrain(terrain), view.camera.camera, from_degrees(options.heading_deg));
  view.landmarks = landmarks_on(view.geometry, options.width, options.height);
  return view;
}

struct SunPlace {
  double zenith_deg, azimuth_deg;
};

// As 8-bit values of a camera with noise.
inline Image<glm::vec3> encoded_in(const GeneratedView& view, const fixtures::Weather& weather, std::uint64_t seed) {
  const fixtures::Illumination illumination(weather);
  const auto light = fixtures::look_at_scene(illumination, view.camera.camera, view.geometry);
  auto exposure = fixtures::automatic_exposure(light, 0.97, 0.58);
  exposure.seed = seed;
  const auto picture = fixtures::expose(light, view.camera.camera, exposure);
  Image<glm::vec3> encoded(picture.width(), picture.height());
  for (std::size_t i = 0; i < encoded.elements().size(); ++i)
    encoded.elements()[i] = glm::vec3(picture.elements()[i]) / 255.0F;
  return encoded;
}

// In Preetham's world.
inline Image<glm::vec3> encoded_under(const GeneratedView& view, double turbidity, const SunPlace& sun,
                                      std::uint64_t seed) {
  fixtures::Weather weather;
  weather.turbidity = turbidity;
  weather.sun = direction_from(from_degrees(sun.zenith_deg), from_degrees(sun.azimuth_deg));
  weather.altitude_m = kValley_m;
  return encoded_in(view, weather, seed);
}

// From the generator's own physics at 1 nm: the channel's loss of light per metre on a level path.
inline double true_extinction_per_m(const Camera& camera, int channel, double turbidity, double path_m) {
  double left = 0.0, all = 0.0;
  const double rayleigh = std::exp(-kValley_m / fixtures::kRayleighScaleHeight_m);
  const double mie = std::exp(-kValley_m / fixtures::kMieScaleHeight_m);
  for (int nm = 380; nm <= 780; ++nm) {
    const double q = camera.sensitivity.at(nm)[channel];
    const double per_m = rayleigh * fixtures::rayleigh_coefficient(nm) + mie * fixtures::mie_coefficient(nm, turbidity);
    left += q * std::exp(-per_m * path_m);
    all += q;
  }
  return -std::log(left / all) / path_m;
}

}  // namespace kasumi
