// Cloudless skies that nobody fitted a model to, as pictures of a sky camera: the spectral atmosphere, and measured
// ones.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"
#include "fixtures/atmosphere/reference_sky.hpp"
#include "fixtures/light/clouds.hpp"

namespace kasumi::test {

// Light of the sky in linear sRGB, any unit, and of the sun's beam on a surface facing it.
struct CloudlessSky {
  std::string name;
  Direction sun{0.0, 0.0, 1.0};
  std::function<glm::dvec3(const Direction&)> light;
  glm::dvec3 sun_irradiance{0.0};
};

// The spectral atmosphere's, at the site's altitude. Tabulated over zenith angle and azimuth after division by the
// phase functions, so that the aureole stays exact.
CloudlessSky simulated_sky(const reference::ReferenceSky& air, double altitude_m, const Direction& sun);

// The measured scans in `folder`, or none. Between their 81 directions ln L is a polynomial in the direction plus
// exponentials of the angle to the sun (least squares, per channel) plus what that leaves, spread by a Gaussian of 15
// deg; nearer to the sun than the nearest direction, some 10 deg, the aureole is those exponentials'.
std::vector<CloudlessSky> measured_skies(const std::string& folder);

struct Shot {
  bool sun_disc = true;
  double brightest = 0.95;  // level of the 98th percentile of the light
  bool noise = false;
  std::uint64_t seed = 1;
  const fixtures::CloudLayer* clouds = nullptr;  // before the sky, white where thin and grey where thick
};
// 8 bits, through the camera's response and vignetting.
Image<Rgb8> photograph(const CloudlessSky& sky, const Camera& camera, const Shot& shot);

}  // namespace kasumi::test
