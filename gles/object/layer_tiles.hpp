// The tiles in which the object's layer is drawn, and their lattice of samples.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "gles/gpu_model/projection.hpp"
#include "gles/scene.hpp"

namespace kasumi {

// Samples lie on a square lattice rotated by atan(1/4): sample (a, b) is at pixel ((4a - b) / 17, (a + 4b) / 17). Each
// pixel holds 17 of them, no two in the same row or column, so vertical and horizontal edges, typical of buildings, get
// 17 steps instead of the 4 of an axis-aligned 4 x 4 grid. The lattice is drawn as an ordinary picture, with the
// projection rotated, and resolved by a sum over these offsets.
constexpr std::array<std::array<int, 2>, 17> kLatticeOffsets{{{0, 0},
                                                              {1, 0},
                                                              {-1, 0},
                                                              {0, 1},
                                                              {0, -1},
                                                              {1, 1},
                                                              {1, -1},
                                                              {-1, 1},
                                                              {-1, -1},
                                                              {2, 0},
                                                              {-2, 0},
                                                              {0, 2},
                                                              {0, -2},
                                                              {2, 1},
                                                              {-2, -1},
                                                              {-1, 2},
                                                              {1, -2}}};
inline const double kSamplesPerPixel = std::sqrt(17.0);  // along the lattice's axes
constexpr int kLargestLattice = 1024;                    // of the buffer that holds a tile's samples

// The distance in pixels to the corner of a square of this many samples, rounded up.
int pixels_of(int samples);

// Columns of a matrix that acts on (x, y, 1).
glm::dmat3 affine(const glm::dvec3& x_row, const glm::dvec3& y_row);

// A tile: its pixels, and the lattice coordinates of the buffer's corner.
class LayerTile {
 public:
  // `spare`: extra samples drawn around those of its pixels.
  LayerTile(const PixelBox& pixels, int spare);
  // The longest side of a tile that fits into the largest buffer.
  static int most_pixels(int spare);

  const PixelBox& box() const { return box_; }
  int samples_around() const { return around_; }  // beyond its pixels' own centres
  glm::ivec2 first_sample() const { return {first_a_, first_b_}; }
  // The used part of the buffer.
  int width() const;
  int height() const;

  // Homogeneous pixels to the clip coordinates of a buffer with `size` samples along a side.
  glm::dmat3 pixel_to_clip(int size) const;
  // Draws that buffer's samples of these pixels, which may lie beyond the tile, into a viewport that is all of it.
  void draw(const PixelBox& pixels, int size) const;
  // gl_FragCoord in the buffer to the picture's pixels.
  glm::dmat3 fragment_to_pixel() const;
  // The same to 0..1 across the tile, from its first to one past its last pixel.
  glm::dmat3 fragment_to_patch() const;
  // Coefficients of the horizon's light across the tile, which lies within one cell of its grid.
  std::array<glm::dvec3, 4> horizon_patch(const AirlightGrid& horizon) const;
  // gl_FragCoord in the layer, which begins at the corner of `layer`, to texture coordinates of that buffer.
  glm::dmat3 layer_fragment_to_sample(const PixelBox& layer, int size) const;

 private:
  PixelBox box_;
  int around_;
  int first_a_;
  int first_b_;
};

// Tiles that cover `box`, split at the lines of the horizon's grid and to fit into the largest buffer.
std::vector<LayerTile> tiles_of(const PixelBox& box, int spare, const AirlightGrid& horizon);

}  // namespace kasumi
