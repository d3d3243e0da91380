#include "base/sky/light_around.hpp"

#include <algorithm>
#include <cmath>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace kasumi {
namespace {

glm::dvec2 folded(const glm::dvec2& place) {
  const glm::dvec2 over = 1.0 - glm::abs(glm::dvec2{place.y, place.x});
  return {std::copysign(over.x, place.x), std::copysign(over.y, place.y)};
}

}  // namespace

glm::dvec2 place_on_map(const Direction& d) {
  const glm::dvec2 place = glm::dvec2{d.x, d.y} / (std::abs(d.x) + std::abs(d.y) + std::abs(d.z));
  return d.z >= 0.0 ? place : folded(place);
}

Direction direction_on_map(const glm::dvec2& place) {
  glm::dvec2 p = place;
  if (std::abs(p.x) > 1.0) p = {std::copysign(2.0, p.x) - p.x, -p.y};
  if (std::abs(p.y) > 1.0) p = {-p.x, std::copysign(2.0, p.y) - p.y};
  const double z = 1.0 - std::abs(p.x) - std::abs(p.y);
  if (z < 0.0) p = folded(p);
  return glm::normalize(glm::dvec3{p, z});
}

const std::vector<MapTexel>& map_texels() {
  static const std::vector<MapTexel> made = [] {
    constexpr int kLast = LightAround::kSize - 1;
    std::vector<MapTexel> list;
    const auto share = [](int at) { return at == 0 || at == kLast ? 0.5 : 1.0; };  // the share of it within the picture
    for (int y = 0; y <= kLast; ++y)
      for (int x = 0; x <= kLast; ++x) {
        const Direction d = direction_on_map(LightAround::place_of(x, y));
        // Solid angle of a surface element of the octahedron seen from its centre, at a distance of 1 / (|x| + |y| +
        // |z|).
        const double from_middle = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
        list.push_back({d, share(x) * share(y) * 4.0 / (kLast * kLast) * std::pow(from_middle, 3)});
      }
    return list;
  }();
  return made;
}

LightAround light_around_of(const std::function<glm::dvec3(const Direction&)>& radiance) {
  // The clear sky changes fastest at the horizon.
  constexpr double kNearHorizon = 0.1, kTexel = 2.0 / (LightAround::kSize - 1);
  LightAround made;
  for (int y = 0; y < LightAround::kSize; ++y)
    for (int x = 0; x < LightAround::kSize; ++x) {
      const glm::dvec2 middle = LightAround::place_of(x, y);
      const int parts = std::abs(direction_on_map(middle).z) < kNearHorizon ? 4 : 1;
      glm::dvec3 sum{0.0};
      for (int j = 0; j < parts; ++j)
        for (int i = 0; i < parts; ++i)
          sum += radiance(direction_on_map(middle + kTexel * ((glm::dvec2{i, j} + 0.5) / double(parts) - 0.5)));
      made.radiance.at(x, y) = glm::vec3(sum / double(parts * parts));
    }
  return made;
}

glm::dvec3 irradiance(const LightAround& light, const Direction& normal) {
  const glm::vec3* radiance = light.radiance.elements().data();
  glm::dvec3 sum{0.0};
  double weights = 0.0;
  for (const MapTexel& texel : map_texels()) {
    const double weight = texel.solid_angle * std::max(0.0, glm::dot(texel.direction, normal));
    sum += weight * glm::dvec3(*radiance++);
    weights += weight;
  }
  return kPi / weights * sum;  // the weights integrate to pi except for discretisation
}

}  // namespace kasumi
