#include "pipeline/lab/bench/drawn_sky.hpp"

#include <cmath>

#include <glm/common.hpp>
#include <glm/matrix.hpp>

namespace kasumi {

Image<Rgb8> drawn_sky(int side, Camera& camera, const SunDirection& sun) {
  camera.name = "sky";
  camera.width = camera.height = side;
  const double half = from_degrees(92.0).value, middle = 0.5 * (side - 1);
  camera.lens = equidistant_lens({middle, middle}, 0.5 * side / half, {half});
  camera.to_world = camera_to_world(from_degrees(180.0), from_degrees(90.0), {0.0});
  const PreethamSky model({3.0}, sun);
  const glm::dmat3 to_light = glm::inverse(camera.light_to_xyz());
  Image<Rgb8> pixels(side, side);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const auto view = camera.direction_at({x, y});
      if (!view || view->z <= 0.0) continue;
      const glm::dvec3 light = 0.1 * (to_light * model.relative_xyz(*view));
      const glm::dvec3 level = 255.0 * camera.response.to_encoded(glm::clamp(light, glm::dvec3{0.0}, glm::dvec3{1.0}));
      pixels.at(x, y) = {static_cast<std::uint8_t>(std::lround(level.r)),
                         static_cast<std::uint8_t>(std::lround(level.g)),
                         static_cast<std::uint8_t>(std::lround(level.b))};
    }
  return pixels;
}

}  // namespace kasumi
