#include "gles/object/layer_tiles.hpp"

#include <cmath>

#include "gles/gl/layer_buffer.hpp"
#include "gles/light/airlight_grid.hpp"

namespace kasumi {
namespace {

constexpr int kReach = 2;  // of the lattice's offsets

// The pixels between first and last where tiles end: at the lines of the horizon's grid, and at the size limit.
std::vector<int> tile_ends(int first, int last, int most, double first_line, double last_line, int lines) {
  std::vector<int> ends;
  const auto go_to = [&](int end) {
    const int begin = ends.empty() ? first : ends.back();
    const int parts = (end - begin + most - 1) / most;
    for (int part = 1; part <= parts; ++part) ends.push_back(begin + (end - begin) * part / parts);
  };
  for (int line = 0; line < lines; ++line) {
    const double at = std::round(first_line + (last_line - first_line) * line / (lines - 1));
    if (at > (ends.empty() ? first : ends.back()) && at < last) go_to(static_cast<int>(at));
  }
  go_to(last);
  return ends;
}

}  // namespace

int pixels_of(int samples) {
  return (5 * samples + 16) / 17;
}

glm::dmat3 affine(const glm::dvec3& x_row, const glm::dvec3& y_row) {
  return {{x_row.x, y_row.x, 0.0}, {x_row.y, y_row.y, 0.0}, {x_row.z, y_row.z, 1.0}};
}

LayerTile::LayerTile(const PixelBox& pixels, int spare)
    : box_(pixels),
      around_(kReach + spare),
      first_a_(4 * pixels.left + pixels.top - around_),
      first_b_(4 * pixels.top - (pixels.right - 1) - around_) {}

int LayerTile::most_pixels(int spare) {
  return (kLargestLattice - 2 * (kReach + spare)) / 5;
}

int LayerTile::width() const {
  return 4 * (box_.right - box_.left) + (box_.bottom - box_.top) + 2 * around_;
}

int LayerTile::height() const {
  return 4 * (box_.bottom - box_.top) + (box_.right - box_.left) + 2 * around_;
}

glm::dmat3 LayerTile::pixel_to_clip(int size) const {
  const double s = 2.0 / size;  // texels to clip space
  return affine({4.0 * s, s, (0.5 - first_a_) * s - 1.0}, {-s, 4.0 * s, (0.5 - first_b_) * s - 1.0});
}

void LayerTile::draw(const PixelBox& pixels, int size) const {
  const glm::dmat3 to_clip = pixel_to_clip(size);
  std::array<float, 8> corners{};
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec3 corner(i % 2 == 0 ? pixels.left : pixels.right, i < 2 ? pixels.top : pixels.bottom, 1.0);
    const glm::dvec3 clip = to_clip * (corner - glm::dvec3{0.5, 0.5, 0.0});
    corners[2 * i] = static_cast<float>(clip.x);
    corners[2 * i + 1] = static_cast<float>(clip.y);
  }
  draw_corners(corners);
}

glm::dmat3 LayerTile::fragment_to_pixel() const {
  const double a = first_a_ - 0.5, b = first_b_ - 0.5;
  return affine({4.0 / 17.0, -1.0 / 17.0, (4.0 * a - b) / 17.0}, {1.0 / 17.0, 4.0 / 17.0, (a + 4.0 * b) / 17.0});
}

glm::dmat3 LayerTile::fragment_to_patch() const {
  const double w = box_.right - box_.left, h = box_.bottom - box_.top;
  return affine({1.0 / w, 0.0, -box_.left / w}, {0.0, 1.0 / h, -box_.top / h}) * fragment_to_pixel();
}

std::array<glm::dvec3, 4> LayerTile::horizon_patch(const AirlightGrid& horizon) const {
  const auto at = [&](int x, int y) { return airlight_at(horizon, {x, y}); };
  const glm::dvec3 first = at(box_.left, box_.top), along = at(box_.right, box_.top) - first;
  const glm::dvec3 down = at(box_.left, box_.bottom) - first;
  return {first, along, down, at(box_.right, box_.bottom) - first - along - down};
}

glm::dmat3 LayerTile::layer_fragment_to_sample(const PixelBox& layer, int size) const {
  const double x = layer.left - 0.5, y = layer.top - 0.5;
  const double s = 1.0 / size;  // texels to texture coordinates
  return affine({4.0 * s, s, (4.0 * x + y - first_a_ + 0.5) * s}, {-s, 4.0 * s, (4.0 * y - x - first_b_ + 0.5) * s});
}

std::vector<LayerTile> tiles_of(const PixelBox& box, int spare, const AirlightGrid& horizon) {
  const int most = LayerTile::most_pixels(spare);
  const glm::dvec2 first = horizon.first_px, last = horizon.last_px;
  const auto rows = tile_ends(box.top, box.bottom, most, first.y, last.y, AirlightGrid::kRows);
  const auto columns = tile_ends(box.left, box.right, most, first.x, last.x, AirlightGrid::kColumns);
  std::vector<LayerTile> tiles;
  int top = box.top;
  for (const int bottom : rows) {
    int left = box.left;
    for (const int right : columns) {
      tiles.emplace_back(PixelBox{left, top, right, bottom}, spare);
      left = right;
    }
    top = bottom;
  }
  return tiles;
}

}  // namespace kasumi
