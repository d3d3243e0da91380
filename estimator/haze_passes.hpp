// The inner loops of estimator/haze_diffusion.
#pragma once

#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "estimator/haze_diffusion.hpp"

namespace kasumi {

// How much flows between each pixel and its right and its lower neighbour of a pass, mirrored at the picture's edges.
class Conductances {
 public:
  Conductances(int width, int height)
      : right_(width, height), left_(width, height), down_(width, height), up_(width, height), rate_(width, height) {}
  // Neighbours one pixel off, g the mean of their rates (H Eq 12).
  void set_means(const Image<float>& rate);
  // `steps_*` may be empty.
  void set_matched(const MatchedPass& pass, const Image<float>& wanted_px2, const Image<float>& steps_along_row,
                   const Image<float>& steps_down_column);

 private:
  friend void symmetric_pass(const Image<glm::vec4>&, int, const Conductances&, Image<glm::vec4>&);
  Image<float> right_, left_, down_, up_, rate_;
};

// `offset_px`: the one the conductances were made for.
void symmetric_pass(const Image<glm::vec4>& from, int offset_px, const Conductances& flow, Image<glm::vec4>& to);

// Pass k of H Eq 11 with Eq 18.
void invariant_pass(const Image<glm::vec4>& from, const Image<float>& rate, double inner_px, int k,
                    Image<glm::vec4>& to);

}  // namespace kasumi
