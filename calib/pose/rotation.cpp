#include "calib/pose/rotation.hpp"

namespace kasumi {

std::optional<glm::dmat3> rotation_between(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& to_a,
                                           const glm::dvec3& to_b, double min_sine) {
  const auto frame = [min_sine](const glm::dvec3& p, const glm::dvec3& q) -> std::optional<glm::dmat3> {
    const glm::dvec3 across = glm::cross(p, q);
    if (!(glm::length(across) > min_sine)) return std::nullopt;
    const glm::dvec3 middle = glm::normalize(p + q), normal = glm::normalize(across);
    return glm::dmat3{middle, normal, glm::cross(middle, normal)};
  };
  const auto from = frame(a, b), to = frame(to_a, to_b);
  if (!from || !to) return std::nullopt;
  return *to * glm::transpose(*from);
}

}  // namespace kasumi
