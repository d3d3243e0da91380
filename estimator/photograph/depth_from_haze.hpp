// Estimates distances in a photograph from its haze, when none were measured.
#pragma once

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "estimator/air/attenuation.hpp"

namespace kasumi {

struct DepthParameters {
  double patch = 0.02;     // side of a neighbourhood, of the picture's longer side
  double kept_haze = 0.9;  // of the haze seen, so that distant things still look distant
  double window = 0.1;     // radius of the guided filter, of the longer side
  double deepest = 6.0;    // optical depth beyond which land looks like sky
};

// A guess, not a measurement: every neighbourhood is assumed to contain something black in some channel, so that its
// light there is haze (dark channel prior, He 2011), in linear light. Something white nearby is mistaken for something
// far away; the edges are the picture's own (guided filter). Distances are only as good as `air` and that
// assumption; the effect of a change of the air depends only on their product, the optical depth. `relative`: light in
// units of the light from infinity, linear; `encoded`: the same picture, 0..1. Metres, all > 0: sky is far away, with a
// gradual transition.
Image<float> depth_from_haze(const Image<glm::vec3>& relative, const Image<glm::vec3>& encoded,
                             const AttenuationNodes& nodes, ScatteringModel model, const AirState& air,
                             const DepthParameters& options = {});

// Light from infinity where no horizon is visible: the median of the pixels with the brightest dark channel, .5 % of
// the picture (He 2011 takes the brightest of .1 %, which is a highlight if there is one). Linear, as `light` is.
glm::dvec3 light_of_thickest_haze(const Image<glm::vec3>& light, const DepthParameters& options = {});
// That light for every pixel: where sky was found (255 in `sky`, empty: nowhere) and is smooth and bright, the sky's
// own, widely blurred; elsewhere the thickest haze's. This preserves a non-uniform sky.
Image<glm::vec3> light_of_haze(const Image<glm::vec3>& light, const Image<glm::vec3>& encoded,
                               const Image<std::uint8_t>& sky, const DepthParameters& options = {});

// Haze that attenuates all colours equally, as droplets larger than the wavelength do: fog, and the thick grey haze of
// cities. M's haze (lambda^-2) would turn such a picture yellow.
AttenuationNodes grey_attenuation_nodes();

}  // namespace kasumi
