// The means of a tile's pixels, for a layer whose samples are spread: the spread along the lattice's columns is a part
// of them, and pixels that share their colour read them instead of their samples.
#pragma once

#include "gles/object/layer_tiles.hpp"
#include "gles/object/point_spread.hpp"

namespace kasumi {

constexpr int kMeansAround_px = 1;  // beyond the tile: pixels that share a colour with one of it

// Of a lattice's column in a pixel's mean, by rows from -(spread_radius + 2) on: the middle column, the next, the one
// after that; columns before the middle have them mirrored.
std::vector<glm::dvec3> mean_weights(const std::vector<double>& spread_weights);

class PixelMeans {
 public:
  // Whether a fragment shader surely has room for the weights.
  static bool have_room_for(const PointSpread& spread);
  // `size`: of the lattice's buffer; `spare`: LayerTile's. Errors: device.
  static Result<PixelMeans> create(const PointSpread& spread, int size, int spare, const GlInfo& info,
                                   Programs& programs);
  // From samples that are spread along the rows, of the tile's pixels in `needed` and of those around them.
  void draw(const LayerBuffer& samples, const LayerTile& tile, const PixelBox& needed) const;
  // For resolve.frag with MEANS, of a layer that begins at the corner of `layer`.
  void bind(const Program& program, const LayerTile& tile, const PixelBox& layer) const;

 private:
  PixelMeans(std::vector<glm::dvec3> weights, int size, int side, LayerBuffer means, const Program& program)
      : weights_(std::move(weights)), size_(size), side_(side), means_(std::move(means)), program_(&program) {}
  std::vector<glm::dvec3> weights_;
  int size_, side_;
  LayerBuffer means_;
  const Program* program_;
};

}  // namespace kasumi
