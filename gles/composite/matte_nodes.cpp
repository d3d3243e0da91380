#include "gles/composite/matte_nodes.hpp"

#include <algorithm>

namespace kasumi {
namespace {

bool is_mixed(std::uint8_t mask) {
  return mask != 0 && mask != 255;
}

// The pixel and its neighbours have this value.
bool is_sure(const Image<std::uint8_t>& mask, const glm::ivec2& at, std::uint8_t value) {
  for (int y = std::max(0, at.y - 1); y <= std::min(mask.height() - 1, at.y + 1); ++y)
    for (int x = std::max(0, at.x - 1); x <= std::min(mask.width() - 1, at.x + 1); ++x)
      if (mask.at(x, y) != value) return false;
  return true;
}

// The eight neighbours, around, as matte.frag has them.
constexpr std::array<glm::ivec2, kMatteDirections> kDirections{
    {{1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}, {-1, -1}, {0, -1}, {1, -1}}};

std::optional<glm::ivec2> first_sure(const Image<std::uint8_t>& mask, glm::ivec2 at, const glm::ivec2& direction,
                                     std::uint8_t value) {
  for (int step = 0; step <= kMatteReach_px && mask.contains(at.x, at.y); ++step, at += direction)
    if (is_sure(mask, at, value)) return at;
  return std::nullopt;
}

// The last node whose middle is not after this pixel's, counted from the picture's corner; -1 before the first.
int node_before(int pixel, int cell_px) {
  return (2 * pixel + 1 + cell_px) / (2 * cell_px) - 1;
}

}  // namespace

glm::ivec2 first_looked_at(const MatteNodes& nodes, const glm::ivec2& node, const glm::ivec2& picture) {
  const glm::ivec2 middle = nodes.corner_px + nodes.cell_px * node + nodes.cell_px / 2;
  return glm::clamp(middle, glm::ivec2{0}, picture - 1);
}

MatteNodes matte_nodes(const Image<std::uint8_t>& mask, const PixelBox& within, int most_columns, int most_rows) {
  PixelBox band{mask.width(), mask.height(), 0, 0};
  for (int y = within.top; y < within.bottom; ++y)
    for (int x = within.left; x < within.right; ++x) {
      if (!is_mixed(mask.at(x, y))) continue;
      band = {std::min(band.left, x), std::min(band.top, y), std::max(band.right, x + 1), std::max(band.bottom, y + 1)};
    }
  MatteNodes made;
  if (band.empty()) return made;
  glm::ivec2 first;
  for (;; made.cell_px *= 2) {
    first = {node_before(band.left, made.cell_px), node_before(band.top, made.cell_px)};
    made.columns = node_before(band.right - 1, made.cell_px) + 2 - first.x;
    made.rows = node_before(band.bottom - 1, made.cell_px) + 2 - first.y;
    if (made.columns <= most_columns && made.rows <= most_rows) break;
  }
  made.corner_px = made.cell_px * first;

  // A mixed pixel lies between four nodes.
  Image<std::uint8_t> needed(made.columns, made.rows, 0);
  for (int y = band.top; y < band.bottom; ++y)
    for (int x = band.left; x < band.right; ++x) {
      if (!is_mixed(mask.at(x, y))) continue;
      const int column = node_before(x, made.cell_px) - first.x, row = node_before(y, made.cell_px) - first.y;
      for (int v = row; v <= row + 1; ++v)
        for (int u = column; u <= column + 1; ++u) needed.at(u, v) = 1;
    }
  for (int v = 0; v < made.rows; ++v)
    for (int u = 0; u < made.columns; ++u) {
      if (needed.at(u, v) == 0) continue;
      MatteNode node;
      node.at = {u, v};
      const glm::ivec2 from = first_looked_at(made, node.at, {mask.width(), mask.height()});
      for (std::size_t i = 0; i < kDirections.size(); ++i) {
        node.clear[i] = first_sure(mask, from, kDirections[i], 255);
        node.front[i] = first_sure(mask, from, kDirections[i], 0);
      }
      made.nodes.push_back(node);
    }
  return made;
}

}  // namespace kasumi
