// Land under the sky: a mesh of rings around the observer.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

namespace kasumi {

// Metres: x east, y north, z up from sea level below the observer, in the tangent plane there: far land lies lower
// because of the Earth's curvature.
struct LandVertex {
  glm::vec3 position{0.0f};
  float altitude_m = 0.0f;  // above the sea
  glm::vec3 normal{0.0f, 0.0f, 1.0f};
  glm::vec3 albedo{0.2f};  // linear sRGB
};

// Point (column, ring) is vertices[ring * columns + column]; rings are ordered outwards, columns clockwise.
struct DomeLand {
  int columns = 0;
  int rings = 0;
  std::vector<LandVertex> vertices;

  bool empty() const { return vertices.empty(); }
  const LandVertex& at(int column, int ring) const {
    return vertices[static_cast<std::size_t>(ring) * static_cast<std::size_t>(columns) +
                    static_cast<std::size_t>(column)];
  }
};

}  // namespace kasumi
