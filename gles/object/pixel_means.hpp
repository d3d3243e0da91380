// The means of a tile's pixels, for a layer whose samples are spread: what is left of the spread is a part of them, and
// pixels that share their colour read them instead of their samples.
#pragma once

#include "gles/object/coarse_spread.hpp"
#include "gles/object/layer_tiles.hpp"
#include "gles/object/point_spread.hpp"

namespace kasumi {

constexpr int kMeansAround_px = 1;  // beyond the tile: pixels that share a colour with one of it

// Of a lattice's column in a pixel's mean, by rows from -(spread_radius + 2) on: the middle column, the next, the one
// after that; columns before the middle have them mirrored.
std::vector<glm::dvec4> mean_weights(const std::vector<double>& spread_weights);

class PixelMeans {
 public:
  // From samples that are spread along the rows, by a narrow spread: that along the columns is left. `size`: of the
  // lattice's buffer; `spare`: LayerTile's. Errors: device.
  static Result<PixelMeans> create(const PointSpread& spread, int size, int spare, const GlInfo& info,
                                   Programs& programs);
  // From those that a coarser lattice keeps.
  static Result<PixelMeans> create(const CoarseSpread& spread, int spare, const GlInfo& info, Programs& programs);
  // Of the tile's pixels in `needed` and of those around them.
  void draw(const LayerBuffer& samples, const LayerTile& tile, const PixelBox& needed) const;
  // For resolve.frag with MEANS, of a layer that begins at the corner of `layer`.
  void bind(const Program& program, const LayerTile& tile, const PixelBox& layer) const;

 private:
  static Result<PixelMeans> create(std::vector<glm::dvec4> weights, const Defines& defines, int lattice, int size,
                                   int spare, const GlInfo& info, Programs& programs);
  PixelMeans(std::vector<glm::dvec4> weights, int lattice, int size, int side, LayerBuffer means,
             const Program& program)
      : weights_(std::move(weights)),
        lattice_(lattice),
        size_(size),
        side_(side),
        means_(std::move(means)),
        program_(&program) {}
  std::vector<glm::dvec4> weights_;
  int lattice_, size_, side_;  // of the samples drawn, of what it is made from, and of itself
  LayerBuffer means_;
  const Program* program_;
};

}  // namespace kasumi
