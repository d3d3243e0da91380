// Which parts of the sky are cloud (or tree, drop, bird): everything that is not clear air.
#pragma once

#include <vector>

#include "estimator/turbidity/element_looks.hpp"
#include "estimator/turbidity/fitted_sky.hpp"
#include "estimator/turbidity/sky_samples.hpp"

namespace kasumi {

struct CloudMaskLimits {
  // How much whiter (ln R/B) and how much more textured than the clear sky expected in that direction a cloud is, in
  // units of the clear sky's own scatter; and the smallest differences that count at all.
  double colour_scatter = 4.0;
  double least_colour = 0.10;
  double texture_scatter = 5.0;
  double least_texture = 0.02;
};

struct CloudMaskResult {
  double clear_fraction = 0.0;  // of the solid angle that could be judged
  Turbidity turbidity;          // for which the sky's colour was expected
};

// Turns PixelUse::clear into PixelUse::cloud where there is a cloud. The expected R/B follows the sky model in
// direction and T with a free white balance, so that a whitish clear sky (T = 9) is not mistaken for cloud.
CloudMaskResult mask_clouds(ElementLight& sky, const ElementGeometry& geometry, const SunDirection& sun,
                            const CloudMaskLimits& options = {}, const ModelToFit& fitted = {});
// The same by one model after the other, where colour and texture of the elements are known. `sky`: no clouds marked;
// `looks` and `geometry` must stay.
class CloudMasks {
 public:
  struct ColourSample {
    Direction view;
    float colour, luminance;  // ln R/B, ln Y
  };
  CloudMasks(const ElementLight& sky, const ElementLooks& looks, const ElementGeometry& geometry,
             const SunDirection& sun, const CloudMaskLimits& options);
  Image<PixelUse> by(const ModelToFit& fitted) const;

 private:
  Image<PixelUse> unmarked_;
  const ElementLooks& looks_;
  const ElementGeometry& geometry_;
  SunDirection sun_;
  CloudMaskLimits options_;
  std::vector<ColourSample> samples_;
  float texture_limit_ = 0.0f;
};

// After a first fit: turns into PixelUse::cloud what differs from the fitted sky's luminance by more than `limit` of ln
// Y, and its surroundings. Catches thin cloud edges that colour does not show. Returns the share of the previously
// clear sky that is still clear.
double mask_outliers(ElementLight& sky, const ElementGeometry& geometry, const SunDirection& sun, Turbidity turbidity,
                     double log_gain, double limit, const FittedSky& fitted = {});

}  // namespace kasumi
