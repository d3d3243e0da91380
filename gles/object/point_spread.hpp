// Applies the camera's point spread to the samples of the object's layer, so that it looks as sharp as its
// surroundings. A Gaussian is separable along any two perpendicular axes, so it runs along the rotated lattice's rows
// and columns, whose samples lie a quarter of a pixel apart: thin columns and slanted edges keep their sub-pixel
// positions.
#pragma once

#include <vector>

#include "gles/gl/layer_buffer.hpp"
#include "gles/gpu_model/programs.hpp"

namespace kasumi {

// The radius of a Gaussian with this sigma in samples: 3.5 standard deviations.
int spread_radius(double sigma);
// Weights of a sample and of its neighbours to one side, 0 .. spread_radius(sigma); over both sides they sum to 1. The
// discrete Gaussian (Lindeberg 1990) keeps the variance even when narrow.
std::vector<double> gaussian_weights(double sigma);

class PointSpread {
 public:
  // sigma: samples, > 0; size: of the lattice's buffer. Errors: device (shaders, buffers).
  static Result<PointSpread> create(double sigma, int size, bool in_8_bits, const GlInfo& info, Programs& programs);
  const std::vector<double>& weights() const { return weights_; }
  // Blurs the buffer's first width x height samples; those at the border lack contributions from beyond it. Requires
  // the dither pattern in kDitherUnit.
  void apply(const LayerBuffer& samples, int width, int height) const;
  // The same along the rows alone; the samples so spread.
  const LayerBuffer& along_rows(const LayerBuffer& samples, int width, int height) const;

 private:
  void pass(const LayerBuffer& from, const LayerBuffer& to, const glm::dvec2& along, int width, int height) const;
  PointSpread(std::vector<double> weights, int size, LayerBuffer between, const Program& program)
      : weights_(std::move(weights)), size_(size), between_(std::move(between)), program_(&program) {}
  std::vector<double> weights_;
  int size_;
  LayerBuffer between_;  // spread along the rows
  const Program* program_;
};

}  // namespace kasumi
