// A clear winter sky over Alpnach in thirteen exposures, linear; see the shared data's README.
#pragma once

#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "calib/camera.hpp"
#include "tests/places.hpp"

namespace kasumi::alpnach {

constexpr int kExposures = 13;
inline const glm::dvec2 kCentre{149.6, 140.7}, kSun{83.3, 80.9};  // pixels
constexpr double kRadius_px = 133.0, kFieldOfView_deg = 185.0;

inline std::filesystem::path file(int exposure) {
  return shared_data_folder() / "sky/skycam-alpnach" /
         fmt::format("Alpnach_20180129_11-09-20_ExposureStack_Image_{:02}_image.png", exposure);
}
inline bool is_there() {
  return std::filesystem::exists(file(0));
}

// What stands above the horizon is up to 25 deg high.
enum class Land { seen, masked };
inline Camera camera(double field_of_view_deg = kFieldOfView_deg, Land land = Land::seen) {
  Camera camera;
  camera.name = "sky";
  camera.width = camera.height = 300;
  const double half = from_degrees(0.5 * field_of_view_deg).value;
  camera.lens = equidistant_lens(kCentre, kRadius_px / half, {half});
  camera.to_world = camera_to_world(from_degrees(180), from_degrees(90), {0});
  camera.response = Response::linear();
  if (land == Land::seen) return camera;
  camera.mask = Image<std::uint8_t>(300, 300);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 300; ++x)
      if (const auto d = camera.direction_at({x, y}))
        camera.mask.at(x, y) = d->z > std::sin(from_degrees(25.0).value) ? 255 : 0;
  return camera;
}

}  // namespace kasumi::alpnach
