// What a picture would show without passers, as a mixture of remembered pictures: in linear light the sun's part and
// the sky's add up whatever shades the sun and whatever the camera's exposure is, so that every light is a sum of
// others. Each window of the picture has a mixture of its own, since clouds shade one place and not the next; what
// stands before the scene is not a mixture of it, and the fit is robust against it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "estimator/passers/scene_memory.hpp"
#include "estimator/passers/tone.hpp"

namespace kasumi {

class LightMix {
 public:
  // Takes the directions in which the pictures differ most (principal components, not centred) in each window.
  void learn(const std::vector<RememberedFrame>& pictures, const Tone& tone);
  bool empty() const { return windows_.empty(); }

  // `light` of each cell; `sigma`: of a cell's usual difference without passers, in steps of 255; 0: unusable.
  void explain(const Image<glm::vec3>& light, const Image<float>& sigma);
  // Of the window that explains a cell best.
  const Image<glm::vec3>& expected() const { return expected_; }
  // How much of each remembered picture is in that; they need not be positive.
  std::span<const float> shares(int column, int row) const;

 private:
  struct Window {
    int column = 0, row = 0, columns = 0, rows = 0;  // cells
    int of_pictures = 0, more = 0;                   // components; and those that let the light fall off within it
    std::vector<float> basis;                        // 3 values of each cell, for each component
    std::vector<float> fitted;                       // the same of every other cell: the fit is made of these
    std::vector<float> made_of;                      // pictures, for each component of pictures
    std::vector<float> scale;                        // of such a component, in all pictures
    std::vector<float> shares;                       // of each picture, as explained last
  };
  Window window_of(int column, int row, int columns, int rows, const std::vector<RememberedFrame>& pictures) const;
  std::vector<float> fit(const Window& window, const std::vector<float>& before) const;

  std::vector<Window> windows_;  // the first is the whole part
  std::size_t pictures_ = 0;
  Image<glm::vec3> steps_;           // steps of 255 for light, of each cell and channel
  Image<glm::vec3> now_, expected_;  // now_: in those steps
  Image<float> weight_, miss2_;
  Image<std::uint16_t> best_;
};

}  // namespace kasumi
