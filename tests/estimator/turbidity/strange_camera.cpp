#include "tests/estimator/turbidity/strange_camera.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <opencv2/imgproc.hpp>

#include "base/statistics.hpp"
#include "base/units.hpp"
#include "fixtures/noise/noise.hpp"
#include "tests/estimator/turbidity/synthetic_sky.hpp"
#include "tests/opencv_pictures.hpp"

namespace kasumi::test {
namespace {

double encoded(const StrangeCamera& camera, double light) {
  const double x = std::clamp(light, 0.0, 1.0);
  const double srgb = Response::srgb().to_encoded(glm::dvec3{x}).x, s = camera.strength;
  switch (camera.curve) {
    case StrangeCamera::Curve::srgb: return srgb;
    case StrangeCamera::Curve::power: return std::pow(x, s);
    case StrangeCamera::Curve::contrast: return std::lerp(srgb, srgb * srgb * (3.0 - 2.0 * srgb), s);
    case StrangeCamera::Curve::film: {
      const double shoulder = 1.0 + 9.0 * s;
      return std::pow(std::log1p(shoulder * x) / std::log1p(shoulder), std::lerp(0.45, 0.7, s));
    }
  }
  return srgb;
}

struct Rays {
  std::mt19937_64 random;
  double uniform() { return static_cast<double>(random() >> 11) * 0x1.0p-53; }
  double between(double low, double high) { return low + (high - low) * uniform(); }
  bool happens(double probability) { return uniform() < probability; }
};

// Elevation of the tree tops by azimuth [rad].
double tree_tops(double azimuth, std::uint64_t seed) {
  const glm::dvec2 round{3.0 * std::cos(azimuth), 3.0 * std::sin(azimuth)};
  return 0.22 + 0.25 * fixtures::fractal_noise(seed, round, 4);
}

// Divides by a power of the surroundings' light.
void flatten(Image<glm::dvec3>& light, const Image<double>& sun_distance, double power) {
  const int side = light.width();
  cv::Mat1f level(side, side, 0.0f), seen(side, side, 0.0f);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      if (sun_distance.at(x, y) >= 0.0) {
        level(y, x) = static_cast<float>(std::log(std::max(1e-9, light.at(x, y).y)));
        seen(y, x) = 1.0f;
      }
  cv::GaussianBlur(level, level, {}, 0.12 * side);
  cv::GaussianBlur(seen, seen, {}, 0.12 * side);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      if (sun_distance.at(x, y) >= 0.0)
        light.at(x, y) *= std::exp(-power * static_cast<double>(level(y, x) / seen(y, x)));
}

}  // namespace

std::string StrangeCamera::text() const {
  const char* const names[] = {"srgb", "power", "contrast", "film"};
  return fmt::format(
      "{} {:.2f}, vignetting {:.2f}, veil {:.3f}, halo {:.3f}, ghost {:.2f}, flattened {:.2f}, white {:.1f}, "
      "saturation {:.2f}, level {:.2f}, jpeg {}, noise {:.3f}{}",
      names[static_cast<int>(curve)], strength, vignetting, veil, halo, ghost, flattened, white_balance, saturation,
      median_level, jpeg_quality, noise, trees ? ", trees" : "");
}

StrangeCamera plain_camera(std::uint64_t seed) {
  Rays dice{std::mt19937_64(seed * 7919 + 5)};
  StrangeCamera camera;
  camera.median_level = dice.between(0.3, 0.5);
  camera.noise = dice.between(0.0, 0.01);
  camera.seed = seed;
  return camera;
}

StrangeCamera any_camera(Population population, std::uint64_t seed) {
  const bool held_out = population == Population::held_out;
  Rays dice{std::mt19937_64(seed * 7919 + (held_out ? 2 : 1))};
  StrangeCamera camera;
  camera.seed = seed + (held_out ? 1000003 : 0);
  const double which = dice.uniform();
  if (which < 0.25) {
    camera.curve = StrangeCamera::Curve::srgb;
  } else if (which < 0.5) {
    camera.curve = StrangeCamera::Curve::power;
    camera.strength = dice.happens(0.3) ? 1.0 : 1.0 / dice.between(1.8, 2.6);
  } else {
    camera.curve = held_out ? StrangeCamera::Curve::film : StrangeCamera::Curve::contrast;
    camera.strength = dice.between(0.2, 1.0);
  }
  if (dice.happens(0.7)) camera.vignetting = dice.between(0.0, 0.5);
  if (dice.happens(0.6)) camera.veil = dice.between(0.01, 0.10);
  if (dice.happens(0.5)) camera.halo = dice.between(0.005, 0.05);
  if (dice.happens(0.3)) camera.ghost = dice.between(0.1, 0.5);
  if (dice.happens(0.7)) camera.white_balance = dice.between(0.2, 1.0);
  camera.saturation = dice.between(0.9, 1.4);
  if (dice.happens(0.15)) camera.flattened = dice.between(0.2, 0.7);
  camera.median_level = dice.between(0.3, 0.75);
  if (dice.happens(0.8)) camera.jpeg_quality = static_cast<int>(dice.between(70.0, 97.0));
  camera.noise = dice.between(0.0, 0.02);
  camera.trees = dice.happens(0.4);
  return camera;
}

Camera believed_camera(int side) {
  Camera camera = upward_camera(side);
  camera.name = "sky";
  return camera;
}

Image<Rgb8> photograph(const PopulationSky& sky, const StrangeCamera& camera, int side) {
  const Camera lens = believed_camera(side);
  constexpr double kDisc_sr = 6.8e-5;
  Image<glm::dvec3> light(side, side, glm::dvec3{0.0});
  Image<double> sun_distance(side, side, -1.0);
  const double pixel_sr = std::pow(kPi / side, 2);
  glm::dvec3 sum{0.0};
  int seen = 0;
  std::vector<double> levels;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const auto d = lens.direction_at({x, y});
      if (!d || d->z <= 0.0) continue;
      const double gamma = angle_between(*d, sky.sun).value;
      sun_distance.at(x, y) = gamma;
      glm::dvec3 rgb = sky.light(*d);
      levels.push_back(rgb.y);
      // The disc, spread over the pixels around it.
      const double spread_sr = std::max(2.0 * pixel_sr, kDisc_sr);
      rgb += sky.beam / (2.0 * kPi * spread_sr) * std::exp(-0.5 * gamma * gamma / spread_sr);
      if (camera.trees && kPi / 2 - zenith_angle(*d).value < tree_tops(azimuth_angle(*d).value, camera.seed))
        rgb = glm::dvec3{0.03, 0.045, 0.02} *
              (0.5 + hashed_uniform(camera.seed, static_cast<std::uint64_t>(y * side + x))) * levels.front();
      light.at(x, y) = rgb;
      sum += sky.light(*d);
      ++seen;
    }
  const glm::dvec3 mean = sum / static_cast<double>(std::max(1, seen));
  const glm::dvec3 all = mean + sky.beam / (2.0 * kPi);
  const Direction opposite{-sky.sun.x, -sky.sun.y, sky.sun.z};
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      if (sun_distance.at(x, y) < 0.0) continue;
      const auto d = lens.direction_at({x, y});
      const double gamma = sun_distance.at(x, y), ghost = angle_between(*d, opposite).value;
      glm::dvec3& rgb = light.at(x, y);
      rgb += camera.veil * all;
      rgb += camera.halo * all * 8.0 * std::exp(-gamma / 0.18);
      rgb += camera.ghost * mean * (ghost < 0.12 ? 1.0 : std::exp(-std::pow((ghost - 0.12) / 0.03, 2)));
      const double r = zenith_angle(*d).value / (0.5 * kPi);
      rgb *= 1.0 - camera.vignetting * r * r;
    }
  if (camera.flattened > 0.0) {
    flatten(light, sun_distance, camera.flattened);
    levels.clear();
    for (int i = 0; i < side * side; ++i)
      if (sun_distance.at(i % side, i / side) >= 0.0) levels.push_back(light.at(i % side, i / side).y);
  }
  const double exposure = Response::srgb().to_light(glm::dvec3{camera.median_level}).x / median_in_place(levels);
  const glm::dvec3 grey = glm::pow(glm::dvec3{mean.y} / mean, glm::dvec3{camera.white_balance});
  Image<Rgb8> picture(side, side);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      glm::dvec3 rgb = exposure * grey * light.at(x, y);
      const double level = glm::dot(rgb, glm::dvec3{0.2126, 0.7152, 0.0722});
      rgb = glm::max(level + camera.saturation * (rgb - level), glm::dvec3{0.0});
      const auto index = 3 * static_cast<std::uint64_t>(y * side + x);
      for (int c = 0; c < 3; ++c) {
        rgb[c] += camera.noise * std::sqrt(std::min(1.0, rgb[c])) *
                  hashed_normal(camera.seed, index + static_cast<std::uint64_t>(c));
        picture.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(255.0 * encoded(camera, rgb[c])));
      }
    }
  return camera.jpeg_quality > 0 ? rgb_of(through_jpeg(bgr_of(picture), camera.jpeg_quality)) : picture;
}

}  // namespace kasumi::test
