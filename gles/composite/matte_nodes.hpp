// Background and foreground of a mixed pixel, by the picture: the nearest pixels where the mask is certain, in eight
// directions from each node of a coarse grid.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>

#include "base/image.hpp"
#include "gles/scene.hpp"

namespace kasumi {

constexpr int kMatteCell_px = 4;     // between nodes; grows where the driver's textures end
constexpr int kMatteReach_px = 96;   // how far is looked for sure pixels
constexpr int kMatteDirections = 8;  // in which sure pixels are looked for

struct MatteNode {
  glm::ivec2 at{};                                                // column, row
  std::array<std::optional<glm::ivec2>, kMatteDirections> clear;  // pixels of the picture where nothing stands in front
  std::array<std::optional<glm::ivec2>, kMatteDirections> front;  // where it covers all
};

struct MatteNodes {
  glm::ivec2 corner_px{};  // of the first node's cell, a multiple of its size
  int cell_px = kMatteCell_px;
  int columns = 0;
  int rows = 0;
  std::vector<MatteNode> nodes;  // those around the mixed pixels
  bool empty() const { return nodes.empty(); }
};

// The pixel from which a node looks for sure ones.
glm::ivec2 first_looked_at(const MatteNodes& nodes, const glm::ivec2& node, const glm::ivec2& picture);

// A pixel of the mask is mixed between 0 and 255. Only those in `within` count. A sure pixel's neighbours are sure in
// the same way, since optics and chroma mix across the edge.
MatteNodes matte_nodes(const Image<std::uint8_t>& mask, const PixelBox& within, int most_columns, int most_rows);

}  // namespace kasumi
