#include "tests/pipeline/install/calibrate/strange_series.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

#include "base/square.hpp"
#include "base/utc_text.hpp"
#include "estimator/sky/sun.hpp"
#include "pipeline/site/files/picture_sink.hpp"

namespace kasumi {
namespace {

// Skies are taken so much darker that little but the sun is white: a camera clips what its lens leaves of the light.
constexpr double kExposed = 0.25;

// Linear light between the four nearest pixels.
glm::dvec3 light_at(const Image<Rgb8>& pixels, const glm::dvec2& at) {
  const int x = std::clamp(static_cast<int>(at.x), 0, pixels.width() - 2);
  const int y = std::clamp(static_cast<int>(at.y), 0, pixels.height() - 2);
  const double u = std::clamp(at.x - x, 0.0, 1.0), v = std::clamp(at.y - y, 0.0, 1.0);
  const auto light = [&](int i, int j) {
    return Response::srgb().to_light(glm::dvec3(pixels.at(x + i, y + j)) / 255.0);
  };
  return (1.0 - v) * ((1.0 - u) * light(0, 0) + u * light(1, 0)) + v * ((1.0 - u) * light(0, 1) + u * light(1, 1));
}

Image<Rgb8> seen_by(const StrangeCamera& camera, const fixtures::SkyPicture& sky) {
  const auto lens = make_lens(camera.lens);
  Image<Rgb8> picture(camera.size, camera.size);
  for (int y = 0; y < camera.size; ++y)
    for (int x = 0; x < camera.size; ++x) {
      const double off = glm::distance(glm::dvec2{x, y}, camera.circle.centre) / camera.circle.radius_px;
      const auto ray = lens->unproject({x, y});
      if (!ray || off > 1.0) continue;
      // Below the horizon is what is at it: a ring of land would be another rim.
      Direction direction = glm::normalize(camera.to_world * *ray);
      direction.z = std::max(direction.z, 0.02);
      const auto pixel = sky.camera.pixel_of(glm::normalize(direction));
      if (!pixel) continue;
      const glm::dvec3 light = std::exp(-camera.rim_loss * square(off)) / kExposed * light_at(sky.pixels, *pixel);
      picture.at(x, y) =
          Rgb8(glm::round(255.0 * Response::srgb().to_encoded(
                                      glm::pow(glm::min(light, glm::dvec3(1.0)), glm::dvec3(camera.tone_exponent)))));
    }
  return picture;
}

}  // namespace

std::vector<fixtures::SkyPicture> skies_of(const SeriesDay& day) {
  std::vector<fixtures::SkyPicture> skies;
  for (const auto& time : day.times) {
    const auto sun = sun_position(parse_utc(time).value(), day.site).direction;
    fixtures::FisheyeRecipe recipe;
    recipe.world = fixtures::World::physical;
    recipe.turbidity = day.turbidity;
    recipe.sun_zenith = zenith_angle(sun);
    recipe.sun_azimuth = azimuth_angle(sun);
    recipe.exposed = kExposed;
    skies.push_back(fixtures::sky_picture(recipe));
  }
  return skies;
}

void write_series(const std::filesystem::path& folder, const SeriesDay& day,
                  const std::vector<fixtures::SkyPicture>& skies, const StrangeCamera& camera) {
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  for (std::size_t i = 0; i < skies.size(); ++i) {
    std::string name;
    for (const char c : day.times[i])
      if (std::isdigit(static_cast<unsigned char>(c)) || c == 'T') name += c == 'T' ? '_' : c;
    ASSERT_TRUE(write_png(folder / (name + ".png"), seen_by(camera, skies[i])));
  }
}

}  // namespace kasumi
