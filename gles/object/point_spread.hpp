// The camera's point spread over the samples of the object's layer: what it does to the hill behind. A Gaussian is the
// same along any two axes at right angles, so it goes along the turned lattice's own rows and columns, whose samples
// lie a quarter of a pixel apart: thin columns and slanted edges keep their places between the pixels.
#pragma once

#include <vector>

#include "gles/gl/layer_buffer.hpp"
#include "gles/gpu_model/programs.hpp"

namespace kasumi {

// How far a Gaussian of that many samples reaches: 3.5 deviations are kept.
int spread_radius(double sigma);
// Weights of a sample and of its neighbours to one side, 0 .. spread_radius(sigma); the whole sums to 1. Its variance
// is that of the Gaussian however narrow it is (the discrete Gaussian, Lindeberg 1990).
std::vector<double> gaussian_weights(double sigma);

class PointSpread {
 public:
  // sigma: samples, > 0; size: of the lattice's buffer. Errors: device (shaders, buffers).
  static Result<PointSpread> create(double sigma, int size, bool in_8_bits, const GlInfo& info, Programs& programs);
  // Spreads the buffer's first width x height samples; those at its border lack what lies beyond it. The dither pattern
  // is bound to kDitherUnit.
  void apply(const LayerBuffer& samples, int width, int height) const;

 private:
  PointSpread(std::vector<double> weights, int size, LayerBuffer between, const Program& program)
      : weights_(std::move(weights)), size_(size), between_(std::move(between)), program_(&program) {}
  std::vector<double> weights_;
  int size_;
  LayerBuffer between_;  // spread along the rows
  const Program* program_;
};

}  // namespace kasumi
