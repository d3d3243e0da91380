// Cameras as they come: a tone curve of their own, automatic white balance, glare of lens and dome, vignetting, JPEG,
// trees. The estimator is told of none of it.
#pragma once

#include <cstdint>
#include <string>

#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "tests/estimator/turbidity/sky_population.hpp"

namespace kasumi::test {

struct StrangeCamera {
  enum class Curve { srgb, power, contrast, film };
  Curve curve = Curve::srgb;
  double strength = 0.0;       // power: the exponent; contrast, film: 0 (sRGB) .. 1
  double vignetting = 0.0;     // light lost at the picture's edge
  double veil = 0.0;           // of all light, spread evenly
  double halo = 0.0;           // of all light and the sun's, spread some 10 deg around the sun
  double ghost = 0.0;          // as bright as this share of the sky, opposite the sun
  double flattened = 0.0;      // of the picture's coarse contrast: local tone mapping, as merged exposures have
  double white_balance = 0.0;  // 0: daylight; 1: the picture's mean is made grey
  double saturation = 1.0;     // of colours
  double median_level = 0.45;  // encoded, of the picture
  int jpeg_quality = 0;        // 0: none
  double noise = 0.0;          // of light, at full scale; grows with its square root
  bool trees = false;
  std::uint64_t seed = 1;
  std::string text() const;
};

// A camera with nothing strange but its white balance; any camera, drawn from `seed`.
StrangeCamera plain_camera(std::uint64_t seed);
StrangeCamera any_camera(Population population, std::uint64_t seed);

// What the estimator believes: equidistant, looking up, sRGB.
Camera believed_camera(int side);
Image<Rgb8> photograph(const PopulationSky& sky, const StrangeCamera& camera, int side);

}  // namespace kasumi::test
