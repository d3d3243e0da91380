// Distances of a photograph of which none were measured, from the haze in it.
#pragma once

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "estimator/air/attenuation.hpp"

namespace kasumi {

struct DepthFromHazeOptions {
  double patch = 0.02;     // side of a neighbourhood, of the picture's longer side
  double kept_haze = 0.9;  // of the haze seen, so that distance stays to be felt
  double window = 0.1;     // radius in which edges of the picture are followed, of the longer side
  double deepest = 6.0;    // optical depth beyond which nothing is told apart: sky
};

// A guess, not a measurement: every neighbourhood is taken to hold something black in some channel, so that what light
// it has is haze (He 2011), in linear light. Something white nearby passes for something far away; the edges are the
// picture's own (guided filter). Distances are as true as `turbidity` and that guess; what a change of the air makes of
// the picture depends on their product, the optical depth, alone.
// `relative`: light in units of the light from infinity, linear; `encoded`: the same picture, 0..1. Metres, all > 0:
// sky is far away, and comes near gradually.
Image<float> depth_from_haze(const Image<glm::vec3>& relative, const Image<glm::vec3>& encoded,
                             const AttenuationNodes& nodes, ScatteringModel model, Turbidity turbidity,
                             const DepthFromHazeOptions& options = {});

// Light from infinity where no horizon is seen: the median of the pixels whose neighbourhoods hold the least dark, .5 %
// of the picture (He 2011 takes the brightest of .1 %, which is a highlight if there is one). Linear, as `light` is.
glm::dvec3 light_of_thickest_haze(const Image<glm::vec3>& light, const DepthFromHazeOptions& options = {});
// That light for every pixel: where sky was found (255 in `sky`, empty: nowhere) and is smooth and bright, the sky's
// own, blurred widely; the thickest haze's elsewhere. A sky that is not the same all over then stays as it is.
Image<glm::vec3> light_of_haze(const Image<glm::vec3>& light, const Image<glm::vec3>& encoded,
                               const Image<std::uint8_t>& sky, const DepthFromHazeOptions& options = {});

// Haze that takes of all colours alike, as droplets larger than the wavelength do: fog, and the thick grey haze of
// cities. M's haze (lambda^-2) would have such a picture come out yellow.
AttenuationNodes grey_attenuation_nodes();

}  // namespace kasumi
