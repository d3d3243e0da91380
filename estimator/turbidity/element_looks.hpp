// Features of a sky picture's elements that separate clear air from cloud without a sky model.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "estimator/turbidity/sky_samples.hpp"

namespace kasumi {

// Per element. Luminance and colour are means over 3 x 3 elements: single ones are noisy.
struct ElementLooks {
  cv::Mat1f known;                        // 1, or 0: saturated, dark, not sky
  cv::Mat1b alone;                        // not 0: more than a fifth of the 5 x 5 elements around are saturated or dark
  cv::Mat1f luminance, colour, texture;   // ln Y, ln R/B, texture_of
  cv::Mat1f luminance_step, colour_step;  // of the quantisation
  // Texture from which an element is rough: `scatter` times the smoother quarter's, no less than `least`.
  float rough(double scatter, double least) const;
};
// `light`: clouds not marked.
ElementLooks looks_of(const SkyPicture& picture, const Camera& camera, const ElementLight& light);

// Some quantity of the known elements, of every fourth.
template <class Quantity>
std::vector<float> some_of(const ElementLooks& looks, const Quantity& quantity) {
  std::vector<float> values;
  for (int y = 0; y < looks.known.rows; y += 2)
    for (int x = 0; x < looks.known.cols; x += 2)
      if (looks.known(y, x) != 0.0f) values.push_back(quantity(x, y));
  return values;
}

}  // namespace kasumi
