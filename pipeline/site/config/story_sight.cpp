#include "pipeline/site/config/story_sight.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "pipeline/site/config/sighting.hpp"

namespace kasumi {

namespace {

constexpr float kSlack_m = 0.5F;  // a place may lie a little behind the surface that it is of

// A line of sight from the camera, in the model's frame, to where it enters the place's box.
struct SightLine {
  glm::dvec3 from, direction;
  double length;
};

double entry_of(const glm::dvec3& from, const glm::dvec3& direction, const ModelBounds& box) {
  double entry = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0.0) continue;
    const double a = (double{box.lowest[axis]} - from[axis]) / direction[axis];
    const double b = (double{box.highest[axis]} - from[axis]) / direction[axis];
    entry = std::max(entry, std::min(a, b));
  }
  return entry;
}

// Moeller and Trumbore; both sides of a surface hide.
bool hides(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const SightLine& line) {
  const glm::dvec3 ab = b - a, ac = c - a, p = glm::cross(line.direction, ac);
  const double det = glm::dot(ab, p);
  if (det == 0.0) return false;
  const glm::dvec3 s = line.from - a;
  const double u = glm::dot(s, p) / det;
  if (u < 0.0 || u > 1.0) return false;
  const glm::dvec3 q = glm::cross(s, ab);
  const double v = glm::dot(line.direction, q) / det;
  if (v < 0.0 || u + v > 1.0) return false;
  const double t = glm::dot(ac, q) / det;
  return t > 0.0 && t < line.length;
}

bool behind_the_building(const Installation& installation, const Model& model, const ModelBounds& place) {
  const glm::dmat4 to_model = glm::inverse(model_to_world(installation.object.placement));
  const glm::dvec3 eye(to_model[3]);
  const float slack = kSlack_m / static_cast<float>(installation.object.placement.scale);
  const ModelBounds box{place.lowest - slack, place.highest + slack};
  const glm::dvec3 lowest(place.lowest), highest(place.highest);
  std::vector<SightLine> lines;
  for (std::size_t i = 0; i <= 8; ++i) {
    const glm::dvec3 at =
        i == 8 ? 0.5 * (lowest + highest)
               : glm::dvec3{i & 1 ? highest.x : lowest.x, i & 2 ? highest.y : lowest.y, i & 4 ? highest.z : lowest.z};
    if (glm::distance(at, eye) == 0.0) return false;
    const glm::dvec3 direction = glm::normalize(at - eye);
    lines.push_back({eye, direction, entry_of(eye, direction, box)});
  }
  for (const ModelPart& part : model.parts)
    for (std::size_t i = 0; i + 2 < part.indices.size() && !lines.empty(); i += 3) {
      const auto corner = [&](std::size_t j) { return glm::dvec3(part.vertices[part.indices[i + j]].position); };
      const glm::dvec3 a = corner(0), b = corner(1), c = corner(2);
      std::erase_if(lines, [&](const SightLine& line) { return hides(a, b, c, line); });
    }
  return lines.empty();
}

}  // namespace

std::string why_unseen(const Installation& installation, const Model& model, const ModelBounds& place) {
  const auto sighting = sight_object(installation, place, "it");
  if (!sighting.in_picture()) return sighting.message;
  return behind_the_building(installation, model, place) ? "it is behind the building" : "";
}

}  // namespace kasumi
