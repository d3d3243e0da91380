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
      : right_(width, height),
        down_(width, height),
        left_of_edge_(width, height),
        above_edge_(width, height),
        rate_(width, height) {}
  // Neighbours one pixel off, g the mean of their rates (H Eq 12).
  void set_means(const Image<float>& rate);
  // `steps_*` may be empty.
  void set_matched(const MatchedPass& pass, const Image<float>& wanted_px2, const Image<float>& steps_along_row,
                   const Image<float>& steps_down_column);

 private:
  friend void symmetric_pass(const Image<glm::vec4>&, int, const Conductances&, Image<glm::vec4>&);
  template <class Between>
  void set(int offset_px, Between between);
  // What flows to the left is what flows to the right of the pixel there; only the first columns and rows, whose left
  // and upper neighbours are mirrored, have their own.
  Image<float> right_, down_, left_of_edge_, above_edge_, rate_;
};

// `offset_px`: the one the conductances were made for.
void symmetric_pass(const Image<glm::vec4>& from, int offset_px, const Conductances& flow, Image<glm::vec4>& to);

// Pass k of H Eq 11 with Eq 18.
void invariant_pass(const Image<glm::vec4>& from, const Image<float>& rate, double inner_px, int k,
                    Image<glm::vec4>& to);

}  // namespace kasumi
