#include "estimator/turbidity/sky_samples.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "base/fast_log.hpp"

namespace kasumi {

namespace {

// Encoded level -> linear light without evaluating a power per pixel.
constexpr int kLevelSteps = 255 * 16;  // 8-bit levels fall on its nodes exactly

std::vector<glm::vec3> light_of_levels(const Response& response) {
  std::vector<glm::vec3> light;
  light.reserve(kLevelSteps + 1);
  for (int i = 0; i <= kLevelSteps; ++i)
    light.emplace_back(response.to_light(glm::dvec3{static_cast<double>(i) / kLevelSteps}));
  return light;
}

class LightTable {
 public:
  explicit LightTable(const std::vector<glm::vec3>& light_of_level) : table_(light_of_level.data()) {}
  glm::vec3 at(const glm::vec3& encoded) const {
    return {channel(encoded, 0), channel(encoded, 1), channel(encoded, 2)};
  }

 private:
  float channel(const glm::vec3& encoded, int c) const {
    const float position = std::clamp(encoded[c], 0.0f, 1.0f) * static_cast<float>(kLevelSteps);
    const int i = std::min(static_cast<int>(position), kLevelSteps - 1);
    const float rest = position - static_cast<float>(i);
    return table_[i][c] * (1.0f - rest) + table_[i + 1][c] * rest;
  }
  const glm::vec3* table_;
};

// What of an element of open sky, high enough, is to be used, and its light.
class ElementReader {
 public:
  ElementReader(const SkyPicture& picture, const ElementGeometry& geometry, const SunDirection& sun,
                const SampleLimits& limits)
      : picture_(picture),
        geometry_(geometry),
        table_(geometry.light_of_level),
        luminance_{geometry.light_to_xyz[0].y, geometry.light_to_xyz[1].y, geometry.light_to_xyz[2].y},
        towards_sun_(sun),
        near_sun_(static_cast<float>(std::cos(limits.least_sun_distance.value))),
        saturated_(static_cast<float>(limits.saturated)),
        dark_(static_cast<float>(limits.dark_quanta * picture.quantum)) {}

  // Its luminance where it is clear, else 0.
  float read(int x, int y, PixelUse& use, glm::vec3& light) const {
    const glm::vec3& encoded = picture_.encoded.at(x, y);
    if (glm::dot(geometry_.direction.at(x, y), towards_sun_) > near_sun_) {
      use = PixelUse::near_sun;
    } else if (std::max({encoded.r, encoded.g, encoded.b}) >= saturated_) {
      use = PixelUse::saturated;
    } else if (!(encoded.r > dark_ && encoded.g > dark_ && encoded.b > dark_)) {  // also excludes NaN
      use = PixelUse::dark;
    } else {
      const glm::vec3 seen = table_.at(encoded) * geometry_.gain.at(x, y);
      const float y_light = glm::dot(luminance_, seen);
      use = y_light > 0.0f ? PixelUse::clear : PixelUse::dark;
      if (use == PixelUse::clear) light = seen;
      return use == PixelUse::clear ? y_light : 0.0f;
    }
    return 0.0f;
  }

 private:
  const SkyPicture& picture_;
  const ElementGeometry& geometry_;
  LightTable table_;
  glm::vec3 luminance_, towards_sun_;
  float near_sun_, saturated_, dark_;
};

// In which of the sky's patches a direction lies.
std::uint8_t patch_of(const glm::vec3& direction) {
  constexpr int kRings = ElementGeometry::kRings, kSectors = ElementGeometry::kSectors;  // short for these
  const double azimuth = std::atan2(static_cast<double>(direction.x), static_cast<double>(direction.y)) + kPi;
  const int sector = std::min(kSectors - 1, static_cast<int>(azimuth / (2.0 * kPi) * kSectors));
  const int ring = std::min(kRings - 1, static_cast<int>(std::acos(direction.z) / 1.4f * kRings));
  return static_cast<std::uint8_t>(ring * kSectors + sector);
}

// Solid angle of an element from the directions of its neighbours [sr].
float solid_angle_at(const Image<glm::vec3>& direction, int x, int y) {
  const auto known = [&](int i, int j) { return direction.contains(i, j) && direction.at(i, j) != glm::vec3{0.0f}; };
  const auto difference = [&](int dx, int dy) -> glm::vec3 {
    const bool after = known(x + dx, y + dy), before = known(x - dx, y - dy);
    if (after && before) return 0.5f * (direction.at(x + dx, y + dy) - direction.at(x - dx, y - dy));
    if (after) return direction.at(x + dx, y + dy) - direction.at(x, y);
    if (before) return direction.at(x, y) - direction.at(x - dx, y - dy);
    return glm::vec3{0.0f};
  };
  return glm::length(glm::cross(difference(1, 0), difference(0, 1)));
}

bool open_in_mask(const Camera& camera, const glm::dvec2& pixel) {
  if (camera.mask.empty()) return true;
  const int x = static_cast<int>(std::lround(pixel.x)), y = static_cast<int>(std::lround(pixel.y));
  return camera.mask.contains(x, y) && camera.mask.at(x, y) != 0;
}

}  // namespace

double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1.0p-53;
}

bool ElementGeometry::fits(const SkyPicture& picture) const {
  return direction.width() == picture.encoded.width() && direction.height() == picture.encoded.height() &&
         step == picture.step && first == picture.first;
}

ElementGeometry sky_geometry(const Camera& camera, const SkyPicture& picture) {
  const int width = picture.encoded.width(), height = picture.encoded.height();
  ElementGeometry geometry{Image<glm::vec3>(width, height),
                           Image<glm::vec3>(width, height),
                           Image<float>(width, height),
                           Image<std::uint8_t>(width, height),
                           Image<std::uint8_t>(width, height),
                           light_of_levels(camera.response),
                           1.0,
                           camera.light_to_xyz(),
                           picture.step,
                           picture.first};
  const glm::dvec2 axis =
      camera.lens->project({0.0, 0.0, 1.0}).value_or(0.5 * glm::dvec2{camera.width - 1, camera.height - 1});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const glm::dvec2 pixel = picture.camera_pixel(x, y);
      const auto direction = camera.direction_at(pixel);
      if (!direction) continue;
      geometry.direction.at(x, y) = glm::vec3(*direction);
      geometry.gain.at(x, y) = glm::vec3(camera.light_at(pixel, glm::dvec3{1.0}));
      geometry.open.at(x, y) = direction->z > 0.0 && open_in_mask(camera, pixel) ? 1 : 0;
      if (geometry.open.at(x, y) != 0) geometry.patch.at(x, y) = patch_of(geometry.direction.at(x, y));
      geometry.rim_px = std::max(geometry.rim_px, glm::distance(pixel, axis));
    }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (geometry.open.at(x, y) != 0) geometry.solid_angle.at(x, y) = solid_angle_at(geometry.direction, x, y);
  return geometry;
}

ElementLight sky_light(const SkyPicture& picture, const ElementGeometry& geometry, const SunDirection& sun,
                       const SampleLimits& limits) {
  const int width = picture.encoded.width(), height = picture.encoded.height();
  const ElementReader reader(picture, geometry, sun, limits);
  const auto lowest = static_cast<float>(std::cos(limits.largest_zenith.value));
  ElementLight sky{Image<PixelUse>(width, height, PixelUse::outside), Image<glm::vec3>(width, height),
                   Image<float>(width, height)};
  for (int y = 0; y < height; ++y) {
    const glm::vec3* directions = geometry.direction.row(y);
    const std::uint8_t* open = geometry.open.row(y);
    float* log_luminance = sky.log_luminance.row(y);
    for (int x = 0; x < width; ++x)
      if (open[x] != 0 && !(directions[x].z < lowest))
        log_luminance[x] = reader.read(x, y, sky.use.at(x, y), sky.light.at(x, y));
    for (int x = 0; x < width; ++x) log_luminance[x] = log_luminance[x] > 0.0f ? fast_log(log_luminance[x]) : 0.0f;
  }
  return sky;
}

void read_nearer(ElementLight& sky, const SkyPicture& picture, const ElementGeometry& geometry, const SunDirection& sun,
                 const SampleLimits& limits) {
  const ElementReader reader(picture, geometry, sun, limits);
  for (int y = 0; y < sky.use.height(); ++y)
    for (int x = 0; x < sky.use.width(); ++x) {
      PixelUse& use = sky.use.at(x, y);
      if (use != PixelUse::near_sun) continue;
      const float luminance = reader.read(x, y, use, sky.light.at(x, y));
      if (luminance > 0.0f) sky.log_luminance.at(x, y) = fast_log(luminance);
    }
}

std::vector<glm::ivec2> draw_elements(const ElementLight& sky, const ElementGeometry& geometry, int count,
                                      std::mt19937_64& random) {
  std::vector<glm::ivec2> clear;
  std::vector<double> up_to;  // cumulative solid angle of the elements
  clear.reserve(sky.use.elements().size());
  up_to.reserve(sky.use.elements().size());
  double sum = 0.0;
  for (int y = 0; y < sky.use.height(); ++y)
    for (int x = 0; x < sky.use.width(); ++x) {
      const auto solid_angle = static_cast<double>(geometry.solid_angle.at(x, y));
      if (sky.use.at(x, y) != PixelUse::clear || !(solid_angle > 0.0)) continue;
      clear.emplace_back(x, y);
      up_to.push_back(sum += solid_angle);
    }
  const auto wanted = static_cast<std::size_t>(std::max(0, count));
  if (clear.size() <= wanted) return clear;

  std::vector<glm::ivec2> drawn;
  std::vector<bool> taken(clear.size(), false);
  for (std::size_t tries = 0; drawn.size() < wanted && tries < 100 * wanted; ++tries) {
    const double position = uniform(random) * sum;
    const auto i =
        std::min(static_cast<std::size_t>(std::ranges::upper_bound(up_to, position) - up_to.begin()), clear.size() - 1);
    if (taken[i]) continue;
    taken[i] = true;
    drawn.push_back(clear[i]);
  }
  return drawn;
}

std::vector<LuminanceSample> samples_at(std::span<const glm::ivec2> elements, const SkyPicture& picture,
                                        const ElementGeometry& geometry, const ElementLight& sky, const Camera& camera,
                                        const SunDirection& sun, const SampleLimits& limits) {
  const glm::dmat3& to_xyz = geometry.light_to_xyz;
  const glm::dvec3 luminance{to_xyz[0].y, to_xyz[1].y, to_xyz[2].y};
  std::vector<LuminanceSample> samples;
  samples.reserve(elements.size());
  for (const glm::ivec2& e : elements) {
    const glm::dvec3 direction(geometry.direction.at(e.x, e.y));
    const glm::dvec3 encoded(picture.encoded.at(e.x, e.y));
    const glm::dvec3 gain(geometry.gain.at(e.x, e.y));
    const glm::dvec3 share = luminance * gain / std::exp(static_cast<double>(sky.log_luminance.at(e.x, e.y)));
    // d ln Y of one step of the encoded value, uniformly distributed over it; and of the photon count.
    const glm::dvec3 step = share * camera.response.slope(encoded) * picture.quantum;
    const glm::dvec3 photons = share * limits.shot_noise * glm::sqrt(camera.response.to_light(encoded));
    LuminanceSample sample;
    sample.zenith = static_cast<float>(zenith_angle(direction).value);
    sample.sun_distance = static_cast<float>(angle_between(direction, sun).value);
    sample.log_luminance = sky.log_luminance.at(e.x, e.y);
    sample.quantisation = static_cast<float>(glm::length(step) / std::sqrt(12.0));
    sample.sigma = static_cast<float>(std::hypot(glm::length(step) / std::sqrt(12.0), glm::length(photons)));
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace kasumi
