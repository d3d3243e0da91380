// Single-image dehazing: the baselines that M compares with. Pictures have the same size; values 0..1.
#pragma once

#include <glm/vec3.hpp>

#include "base/image.hpp"

namespace kasumi::paper {

// He 2011: in haze-free pictures every patch contains something dark in some channel; the light there is haze.
struct DarkChannelOptions {
  int patch_px = 15;
  double kept_haze = 0.95;  // omega: some haze is kept as a depth cue
  double lowest_transmission = 0.1;
  int radius_px = 60;  // of the guided filter, which replaced matting in He 2013
  double epsilon = 1e-3;
};
// Smallest channel of a picture, smallest in the patch around each pixel.
Image<float> dark_channel(const Image<glm::vec3>& picture, int patch_px);
// `relative`: the picture in units of the light from infinity; `guide`: the picture.
Image<float> transmission_by_dark_channel(const Image<glm::vec3>& relative, const Image<glm::vec3>& guide,
                                          const DarkChannelOptions& options = {});
// He 2011 Sect 4.3: the brightest of the .1 % of pixels whose dark channel is brightest.
glm::dvec3 airlight_by_dark_channel(const Image<glm::vec3>& picture, const DarkChannelOptions& options = {});

// Zhu 2015: depth is a linear function of value and saturation, learnt from 500 pictures with synthetic haze.
struct ColourAttenuationOptions {
  double offset = 0.121779, of_value = 0.959710, of_saturation = -0.780245;  // Zhu 2015, Sect III
  double scattering = 1.0;                                                   // beta
  int patch_px = 15;
  int radius_px = 60;
  double epsilon = 1e-3;
  double lowest_transmission = 0.1, highest_transmission = 0.9;
};
// Per pixel, before the local minimum and the guided filter; dimensionless.
float depth_by_colour(const glm::vec3& encoded, const ColourAttenuationOptions& options = {});
Image<float> transmission_by_colour(const Image<glm::vec3>& encoded, const ColourAttenuationOptions& options = {});

// The scene of `relative` where haze is `thickness` times as thick: each pixel's transmission t becomes t^thickness,
// the surfaces keep their light in units of the light from infinity (M Eq 25, 26). 0: without haze.
Image<glm::vec3> with_haze_of(const Image<glm::vec3>& relative, const Image<float>& transmission, double thickness);

}  // namespace kasumi::paper
