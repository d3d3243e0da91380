#include "tests/gles/shadow/reference_shadow.hpp"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "base/units.hpp"

namespace kasumi {
namespace {

constexpr double kDiscRadius_deg = 0.2665;

}  // namespace

ReferenceShadow::ReferenceShadow(const Model& model, const glm::dmat4& model_to_world, const glm::dvec3& sun,
                                 std::function<double(const ModelMaterial&, glm::dvec2)> alpha)
    : alpha_(std::move(alpha)), cells_(kCells * kCells) {
  across_ = glm::normalize(glm::cross(sun, std::abs(sun.x) < 0.9 ? glm::dvec3{1, 0, 0} : glm::dvec3{0, 1, 0}));
  up_ = glm::cross(sun, across_);
  // Rings of equal area, rotated against each other.
  constexpr int kRings = 6, kTurns = 10;
  const double reach = std::tan(from_degrees(kDiscRadius_deg).value);
  for (int ring = 0; ring < kRings; ++ring)
    for (int i = 0; i < kTurns; ++i) {
      const double radius = reach * std::sqrt((ring + 0.5) / kRings), turn = 2.0 * kPi * (i + 0.382 * ring) / kTurns;
      towards_.push_back(glm::normalize(sun + radius * (std::cos(turn) * across_ + std::sin(turn) * up_)));
    }
  for (const ModelPart& part : model.parts) {
    const ModelMaterial& material = model.materials[static_cast<std::size_t>(part.material)];
    if (material.alpha == ModelMaterial::Alpha::blend) continue;
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
      Caster caster{{}, {}, &material};
      for (std::size_t j = 0; j < 3; ++j) {
        const ModelVertex& vertex = part.vertices[part.indices[i + j]];
        caster.corners[j] = glm::dvec3(model_to_world * glm::dvec4(vertex.position, 1.0));
        caster.places[j] = vertex.texture;
        const glm::dvec2 seen{glm::dot(across_, caster.corners[j]), glm::dot(up_, caster.corners[j])};
        lowest_ = glm::min(lowest_, seen);
        highest_ = glm::max(highest_, seen);
      }
      casters_.push_back(caster);
    }
  }
  // A ray to the disc's edge leaves its cell by at most this over a kilometre.
  const double wander = 1000.0 * reach;
  for (std::size_t i = 0; i < casters_.size(); ++i) {
    glm::dvec2 low{1e300}, high{-1e300};
    for (const glm::dvec3& corner : casters_[i].corners) {
      low = glm::min(low, {glm::dot(across_, corner), glm::dot(up_, corner)});
      high = glm::max(high, {glm::dot(across_, corner), glm::dot(up_, corner)});
    }
    const glm::ivec2 first = cell_of(low - wander), last = cell_of(high + wander);
    for (int y = first.y; y <= last.y; ++y)
      for (int x = first.x; x <= last.x; ++x) cells_[static_cast<std::size_t>(y * kCells + x)].push_back(i);
  }
}

glm::ivec2 ReferenceShadow::cell_of(glm::dvec2 across) const {
  const glm::dvec2 share = (across - lowest_) / glm::max(highest_ - lowest_, glm::dvec2{1e-9});
  return glm::ivec2(glm::clamp(glm::floor(share * double(kCells)), 0.0, kCells - 1.0));
}

// Moeller and Trumbore, from a millimetre on: a face does not hide itself.
bool ReferenceShadow::hides(const Caster& caster, const glm::dvec3& from, const glm::dvec3& towards) const {
  const glm::dvec3 a = caster.corners[1] - caster.corners[0], b = caster.corners[2] - caster.corners[0];
  const glm::dvec3 p = glm::cross(towards, b);
  const double determinant = glm::dot(a, p);
  if (std::abs(determinant) < 1e-15) return false;
  const glm::dvec3 o = from - caster.corners[0], q = glm::cross(o, a);
  const double u = glm::dot(o, p) / determinant, v = glm::dot(towards, q) / determinant;
  if (u < 0.0 || v < 0.0 || u + v > 1.0 || glm::dot(b, q) / determinant < 0.001) return false;
  if (caster.material->alpha != ModelMaterial::Alpha::mask) return true;
  const glm::dvec2 place = (1.0 - u - v) * caster.places[0] + u * caster.places[1] + v * caster.places[2];
  return alpha_(*caster.material, place) >= double(caster.material->alpha_cutoff);
}

double ReferenceShadow::seen(const glm::dvec3& point) const {
  const glm::dvec2 across{glm::dot(across_, point), glm::dot(up_, point)};
  const glm::ivec2 cell = cell_of(across);
  const auto& near = cells_[static_cast<std::size_t>(cell.y * kCells + cell.x)];
  int free = 0;
  for (const glm::dvec3& towards : towards_)
    free += std::ranges::none_of(near, [&](std::size_t i) { return hides(casters_[i], point, towards); }) ? 1 : 0;
  return double(free) / double(towards_.size());
}

}  // namespace kasumi
