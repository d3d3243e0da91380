// A wide point spread by way of a coarser lattice. A Gaussian is two narrower ones after another; what the first has
// spread along rows and columns changes so slowly that every second to fourth sample each way holds all of it. The
// second, from those few straight to the pixels' means, is a matter of MeanWeights.
#pragma once

#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "gles/gl/layer_buffer.hpp"
#include "gles/gpu_model/programs.hpp"
#include "gles/object/layer_tiles.hpp"

namespace kasumi {

// Sigmas in samples.
struct SplitSpread {
  int step = 1;  // samples from one that is kept to the next, at most 4; 1: too narrow, all are needed
  double first = 0.0, second = 0.0;
};
SplitSpread split_spread(double sigma);

// Of the kept samples around a pixel, along rows as along columns: that before the pixel's central sample is element
// `before`. One component for each number of samples that lie between the two. Each component sums to 1.
struct CoarseWeights {
  int before = 0;
  std::vector<glm::dvec4> weights;
  int reach_samples(int step) const { return step * static_cast<int>(weights.size()); }
};
CoarseWeights coarse_weights(const SplitSpread& split);

class CoarseSpread {
 public:
  // `split` of a wide spread; size: of the lattice's buffer. Errors: device.
  static Result<CoarseSpread> create(const SplitSpread& split, int size, const GlInfo& info, Programs& programs);
  int step() const { return split_.step; }
  int lattice() const { return lattice_; }  // size of its buffer
  int size() const { return size_; }        // of the square that is kept
  const CoarseWeights& weights() const { return weights_; }
  // One after the other: what the tile's pixels in `needed` are made of, spread by the first Gaussian.
  void along_rows(const LayerBuffer& samples, const LayerTile& tile, const PixelBox& needed) const;
  const LayerBuffer& along_columns(const LayerTile& tile, const PixelBox& needed) const;

 private:
  CoarseSpread(const SplitSpread& split, int lattice, int size, LayerBuffer rows, LayerBuffer both,
               const Program& program);
  void pass(const LayerBuffer& from, glm::ivec2 from_size, const LayerBuffer& to, glm::ivec2 to_size,
            const glm::dvec2& along, const LayerTile& tile, const PixelBox& pixels) const;

  SplitSpread split_;
  CoarseWeights weights_;
  std::vector<double> first_weights_;
  int lattice_, size_;
  LayerBuffer rows_, both_;  // spread along rows, every row kept; along both
  const Program* program_;
};

}  // namespace kasumi
