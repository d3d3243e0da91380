#include "pipeline/install/camera_drift/drift_frames.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/statistics.hpp"
#include "estimator/sky/preetham.hpp"
#include "estimator/sky/sun.hpp"
#include "estimator/sky_camera/sun_in_image.hpp"

namespace kasumi {
namespace {

constexpr Radians kLowestSun = from_degrees(10.0);    // below, refraction and haze move and dim the disc
constexpr Radians kFarthestSun = from_degrees(15.0);  // from the ephemeris: anything farther is a reflection
constexpr Radians kLargestSun = from_degrees(3.0);    // radius with glare: bright clouds are larger
constexpr int kBesideObstruction_px = 6;              // of the shrunk picture
// Elevation: trees and houses that a sky camera's mask may miss end there.
constexpr Radians kLowSky = from_degrees(15.0);
// A dome's light is judged neither near the sun, where glare moves with it, nor low, where trees are.
constexpr Radians kNearSun = from_degrees(20.0), kLowForDome = from_degrees(20.0);

GreyImage grey_of(const Image<Rgb8>& picture) {
  GreyImage grey(picture.width(), picture.height());
  std::transform(picture.elements().begin(), picture.elements().end(), grey.elements().begin(),
                 [](const Rgb8& c) { return static_cast<std::uint8_t>((2 * c.r + 5 * c.g + c.b + 4) / 8); });
  return grey;
}

DomeFrame dome_look(const Image<Rgb8>& picture, const Camera& camera) {
  const int factor = std::max(1, (std::max(camera.width, camera.height) + kDomeSide_px - 1) / kDomeSide_px);
  DomeFrame dome(picture.width() / factor, picture.height() / factor);
  std::array<glm::vec3, 256> light;
  for (int i = 0; i < 256; ++i) light[static_cast<std::size_t>(i)] = camera.response.to_light(glm::dvec3(i / 255.0));
  for (int y = 0; y < dome.height(); ++y)
    for (int x = 0; x < dome.width(); ++x) {
      glm::vec3 sum{0.0f};
      for (int j = 0; j < factor; ++j)
        for (int i = 0; i < factor; ++i) {
          const auto& c = picture.at(x * factor + i, y * factor + j);
          sum += glm::vec3(light[c.r].r, light[c.g].g, light[c.b].b);
        }
      dome.at(x, y) = sum / static_cast<float>(factor * factor);
    }
  return dome;
}

// ln of the light per unit of the fit's gain in the sky model: F(0, sun) over the zenith luminance.
double log_model_scale(Turbidity turbidity, const SunPosition& sun) {
  const double ratio = perez(perez_coefficients(PerezQuantity::luminance, turbidity), 1.0, sun.zenith);
  const double zenith = PreethamSky(turbidity, sun.direction).zenith_luminance();
  return std::log(std::max(1e-6, ratio) / std::max(1e-3, zenith));
}

}  // namespace

GreyImage median_of(const std::vector<GreyImage>& pictures) {
  if (pictures.empty()) return {};
  GreyImage still(pictures[0].width(), pictures[0].height());
  std::vector<std::uint8_t> values(pictures.size());
  for (std::size_t i = 0; i < still.elements().size(); ++i) {
    for (std::size_t k = 0; k < pictures.size(); ++k) values[k] = pictures[k].elements()[i];
    still.elements()[i] = median_in_place(values);
  }
  return still;
}

std::optional<double> median_if_enough(std::vector<double> values) {
  if (values.size() < std::size_t{kFewestCheckFrames}) return std::nullopt;
  return median_in_place(values);
}

int shrink_factor(const Camera& camera) {
  return std::max(1, (std::max(camera.width, camera.height) + kCheckSide_px - 1) / kCheckSide_px);
}

Image<float> light_of(const GreyImage& picture, const Camera& camera) {
  std::array<float, 256> light;
  for (int i = 0; i < 256; ++i)
    light[static_cast<std::size_t>(i)] = static_cast<float>(camera.response.to_light(glm::dvec3(i / 255.0)).y);
  Image<float> linear(picture.width(), picture.height());
  std::transform(picture.elements().begin(), picture.elements().end(), linear.elements().begin(),
                 [&](std::uint8_t value) { return light[value]; });
  return linear;
}

ShrunkView shrunk_view(const GreyImage& picture, const Camera& camera, Image<std::uint8_t> usable) {
  const int factor = shrink_factor(camera);
  const auto light = light_of(picture, camera);
  ShrunkView small{Image<float>(picture.width() / factor, picture.height() / factor), factor, std::move(usable)};
  for (int y = 0; y < small.light.height(); ++y)
    for (int x = 0; x < small.light.width(); ++x) {
      double sum = 0.0;
      for (int j = 0; j < factor; ++j)
        for (int i = 0; i < factor; ++i) sum += double{light.at(x * factor + i, y * factor + j)};
      small.light.at(x, y) = static_cast<float>(sum / (factor * factor));
    }
  return small;
}

Image<std::uint8_t> still_part_of_sky(const Camera& sky, int factor) {
  Image<std::uint8_t> part(sky.width / factor, sky.height / factor, 0);
  const auto blocked = [&](int x, int y) { return sky.mask.at(x * factor + factor / 2, y * factor + factor / 2) == 0; };
  const int reach = kBesideObstruction_px * shrink_factor(sky) / factor;
  for (int y = 0; y < part.height(); ++y)
    for (int x = 0; x < part.width(); ++x) {
      const glm::dvec2 pixel = (glm::dvec2{x, y} + 0.5) * double(factor) - 0.5;
      const auto direction = sky.direction_at(pixel);
      if (!direction) continue;
      if (sky.mask.empty()) {
        part.at(x, y) = zenith_angle(*direction) > from_degrees(90.0) - kLowSky ? 255 : 0;
        continue;
      }
      bool near_obstruction = false;
      for (const auto& [dx, dy] : {std::pair{0, 0}, {reach, 0}, {-reach, 0}, {0, reach}, {0, -reach}})
        near_obstruction = near_obstruction || (part.contains(x + dx, y + dy) && blocked(x + dx, y + dy));
      part.at(x, y) = near_obstruction ? 255 : 0;
    }
  return part;
}

Image<std::uint8_t> open_sky(const Camera& sky, int width, int height, const std::vector<Direction>& suns) {
  const int factor = std::max(1, sky.width / std::max(1, width));
  Image<std::uint8_t> open(width, height, 0);
  const auto clear = [&](int x, int y) {
    if (sky.mask.empty()) return true;
    const int cx = x * factor + factor / 2, cy = y * factor + factor / 2;
    return sky.mask.contains(cx, cy) && sky.mask.at(cx, cy) != 0;
  };
  for (int y = 0; y < open.height(); ++y)
    for (int x = 0; x < open.width(); ++x) {
      const auto direction = sky.direction_at((glm::dvec2{x, y} + 0.5) * double(factor) - 0.5);
      if (!direction || zenith_angle(*direction) > from_degrees(90.0) - kLowForDome) continue;
      bool whole = true;
      for (const auto& [dx, dy] : {std::pair{0, 0}, {2, 0}, {-2, 0}, {0, 2}, {0, -2}})
        whole = whole && clear(x + dx, y + dy);
      for (const auto& sun : suns) whole = whole && angle_between(*direction, sun) > kNearSun;
      open.at(x, y) = whole ? 255 : 0;
    }
  return open;
}

DriftFrames::DriftFrames(const Installation& installation)
    : scene_camera_(installation.scene), site_(installation.site), observer_(installation.sky) {}

void DriftFrames::add_scene(const PictureView& view) {
  if (view.width == scene_camera_.width && view.height == scene_camera_.height) scene_.push_back(grey_of(to_rgb(view)));
}

void DriftFrames::add_sky(const PictureView& view, const FrameMetadata& metadata, std::optional<Utc> utc) {
  const auto& camera = observer_.camera();
  const auto picture = sky_picture(view, camera);
  if (!picture) return;
  const auto rgb = to_rgb(view);
  sky_.push_back(grey_of(rgb));
  dome_.push_back(dome_look(rgb, camera));
  if (!utc) return;
  const auto sun = sun_position(*utc, site_);
  sun_places_.push_back(sun.direction);
  if (sun.zenith > from_degrees(90.0) - kLowestSun) return;
  const auto fine = sky_picture(view, camera, kLargestSide);
  const auto blob = fine ? find_sun(*fine, camera) : std::nullopt;
  if (blob && blob->radius < kLargestSun && angle_between(blob->direction, sun.direction) < kFarthestSun)
    suns_.push_back({sun.direction, blob->direction});
  const auto observation = observer_.observe(*picture, sun.direction);
  if (!observation.estimate.usable) return;
  turbidities_.push_back(observation.estimate.turbidity.value);
  if (!metadata.exposure_s || !(*metadata.exposure_s > 0.0)) return;
  levels_.push_back(observation.log_gain + log_model_scale(observation.estimate.turbidity, sun) -
                    std::log(*metadata.exposure_s * metadata.gain.value_or(1.0)));
}

}  // namespace kasumi
