#include <meshoptimizer.h>

#include "gles/packed/module.hpp"

namespace kasumi {

std::vector<std::uint32_t> simplified_mesh(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices,
                                           float error) {
  std::vector<std::uint32_t> fewer(indices.size());
  if (indices.empty()) return fewer;
  const float* first = &positions.front().x;
  const float extent = meshopt_simplifyScale(first, positions.size(), sizeof(glm::vec3));
  if (!(extent > 0.0f)) return {indices.begin(), indices.end()};
  fewer.resize(meshopt_simplify(fewer.data(), indices.data(), indices.size(), first, positions.size(),
                                sizeof(glm::vec3), 0, error / extent, 0, nullptr));
  return fewer;
}

}  // namespace kasumi
