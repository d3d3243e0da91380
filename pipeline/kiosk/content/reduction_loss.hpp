// What a coarser model loses in the scene camera's picture.
#pragma once

#include <memory>
#include <vector>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "gles/gl/context.hpp"
#include "gles/model/model.hpp"
#include "pipeline/site/config/installation.hpp"

namespace kasumi {

// One or more scenes of a model at its place, each under three suns, without the camera's noise.
struct ReductionDrawings {
  struct Drawing {
    Image<Rgb8> picture, without;  // with the model, and what lies behind it
  };
  std::vector<Drawing> drawings;

  // Errors: bad_input (the model), device.
  static Result<ReductionDrawings> draw(GlContext& context, const Installation& installation,
                                        const std::vector<std::shared_ptr<const Model>>& scenes);
};

// Absolute differences of 255, over the three channels of the pixels that either model changes.
struct ReductionLoss {
  double mean = 0.0, worst_mean = 0.0;  // over all drawings, and over the worst of them
  double worst_pixel = 0.0;             // mean of its channels
  std::size_t pixels = 0;               // most in one drawing
};
ReductionLoss loss(const ReductionDrawings& original, const ReductionDrawings& coarser);

}  // namespace kasumi
