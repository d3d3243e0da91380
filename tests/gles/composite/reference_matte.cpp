#include "tests/gles/composite/reference_matte.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <glm/geometric.hpp>

namespace kasumi {
namespace {

glm::dvec3 light_at(const ReferenceScene& scene, const Image<Rgb8>& camera, int x, int y) {
  const Rgb8 pixel = camera.at(std::clamp(x, 0, camera.width() - 1), std::clamp(y, 0, camera.height() - 1));
  glm::dvec3 light;
  for (int c = 0; c < 3; ++c) light[c] = reference_light(scene.response, c, pixel[c] / 255.0);
  return light;
}

// Square root of the mean light of the nearest sure pixels in eight directions.
std::optional<glm::dvec3> node(const ReferenceScene& scene, const Image<Rgb8>& camera, int column, int row,
                               std::uint8_t value, double falloff) {
  const auto& mask = scene.mask;
  const auto sure = [&](int x, int y) {
    for (int v = y - 1; v <= y + 1; ++v)
      for (int u = x - 1; u <= x + 1; ++u)
        if (mask.contains(u, v) && mask.at(u, v) != value) return false;
    return true;
  };
  glm::dvec3 sum{0.0};
  double weights = 0.0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      if (dx == 0 && dy == 0) continue;
      int x = std::clamp(4 * column + 2, 0, mask.width() - 1), y = std::clamp(4 * row + 2, 0, mask.height() - 1);
      for (int step = 0; step <= 96 && mask.contains(x, y); ++step, x += dx, y += dy) {
        if (!sure(x, y)) continue;
        const double weight = std::pow(std::hypot(x - 4 * column - 1.5, y - 4 * row - 1.5) + 1.0, falloff);
        sum += weight * light_at(scene, camera, x, y);
        weights += weight;
        break;
      }
    }
  if (weights <= 0.0) return std::nullopt;
  return glm::sqrt(sum / weights);
}

// Between the four nodes around the pixel, of those that know anything.
std::optional<glm::dvec3> light_near(const ReferenceScene& scene, const Image<Rgb8>& camera, int x, int y,
                                     std::uint8_t value, double falloff) {
  const double u = (x + 0.5) / 4.0 - 0.5, v = (y + 0.5) / 4.0 - 0.5;
  glm::dvec3 sum{0.0};
  double weights = 0.0;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const int column = static_cast<int>(std::floor(u)) + i, row = static_cast<int>(std::floor(v)) + j;
      const double weight = (1.0 - std::abs(u - column)) * (1.0 - std::abs(v - row));
      const auto found = node(scene, camera, column, row, value, falloff);
      if (!found) continue;
      sum += weight * *found;
      weights += weight;
    }
  if (weights <= 0.0) return std::nullopt;
  return (sum / weights) * (sum / weights);
}

// How far the mask's share is believed: it falls steeply.
double trust(const Image<std::uint8_t>& mask, int x, int y) {
  int low = 255, high = 0;
  for (int v = y - 1; v <= y + 1; ++v)
    for (int u = x - 1; u <= x + 1; ++u)
      if (mask.contains(u, v)) low = std::min<int>(low, mask.at(u, v)), high = std::max<int>(high, mask.at(u, v));
  return std::clamp((high - low - 215.0) / (255.0 - 215.0), 0.0, 1.0);
}

}  // namespace

ReferenceMatte reference_matte(const ReferenceScene& scene, const Image<Rgb8>& camera, int x, int y) {
  const glm::dvec3 now = light_at(scene, camera, x, y), luma{0.299, 0.587, 0.114};
  const double usual = 1.0 - scene.mask.at(x, y) / 255.0;
  const auto behind = light_near(scene, camera, x, y, 255, -2.0), front = light_near(scene, camera, x, y, 0, -1.0);
  if (!behind) return {1.0 - usual, (1.0 - usual) * now};
  if (!front) return {1.0 - usual, (1.0 - usual) * *behind};
  const glm::dvec3 towards = *front - *behind;
  const double size2 = glm::dot(luma * towards, towards), least2 = 0.0064 * glm::dot(luma * *behind, *behind) + 4e-6;
  const auto place = [&](const glm::dvec3& light) { return glm::dot(luma * towards, light - *behind) / size2; };
  double low = 0.0, lows = 0.3, high = 0.3, highs = 0.3;
  for (int v = -2; v <= 2; ++v)
    for (int u = -2; u <= 2; ++u) {
      if (u * u + v * v > 4) continue;
      const double at = std::clamp(place(light_at(scene, camera, x + u, y + v)), -0.5, 1.5);
      const double is_clear = std::clamp((0.3 - at) / 0.15, 0.0, 1.0);
      const double is_front = std::clamp((at - 0.7) / 0.15, 0.0, 1.0);
      low += is_clear * at, lows += is_clear;
      high += is_front * at, highs += is_front;
    }
  low /= lows;
  high /= highs;
  double covered = std::clamp((place(now) - low) / std::max(high - low, 0.1) + 0.1 * (usual - 0.5), 0.0, 1.0);
  const double trusted = trust(scene.mask, x, y), leaf_variance = std::lerp(25.0, 1.0, trusted);
  covered = std::lerp(covered, usual, trusted);
  covered = std::lerp(usual, covered, size2 / (size2 + least2));
  const double open = 1.0 - covered, share = open * open / (open * open + leaf_variance * covered * covered);
  const glm::dvec3 unexplained = now - *behind - covered * towards;
  return {open, glm::max(open * *behind + share * unexplained, glm::dvec3{0.0})};
}

}  // namespace kasumi
