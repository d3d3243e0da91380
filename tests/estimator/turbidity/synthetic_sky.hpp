// Skies of known turbidity for the tests, implemented from the tables of Perez 1993 and Preetham 1999 without the
// estimator's code: Preetham's sky colours, the sun's disc, connected clouds, exposure, noise, response, quantisation.
#pragma once

#include <cstdint>
#include <functional>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "base/picture.hpp"
#include "calib/camera.hpp"

namespace kasumi::test {

// Y [kcd/m2], x, y of the clear sky.
glm::dvec3 preetham_yxy(double turbidity, double zenith, double sun_zenith, double gamma);

enum class Weather { clear, overcast, fog, covered_dark, covered_bright };

struct SyntheticSky {
  double turbidity = 3.0;
  double sun_zenith_deg = 58.4;
  double sun_azimuth_deg = -179.4;
  double cloud_cover = 0.0;  // share of the solid angle down to 80 deg from the zenith
  std::uint64_t cloud_seed = 1;
  double cloud_scale = 1.5;  // lattice cells per unit of the cloud plane: fewer make larger clouds
  bool sun_disc = true;
  Weather weather = Weather::clear;
  double exposure = 1.0;  // 1: the brightest sky 10 deg from the sun just saturates
  double noise = 0.0;     // shot noise, relative standard deviation at full scale
  std::uint64_t noise_seed = 1;
  double flare = 0.0;                                      // of all light, spread uniformly over the picture
  std::function<glm::dvec3(const Direction&)> clear = {};  // XYZ, kcd/m2, instead of Preetham's sky
};

// A camera looking straight up, the image circle filling the picture; azimuth grows counter-clockwise from the top.
Camera upward_camera(int side, double field_of_view_deg = 180.0, Response response = Response::srgb());

struct RenderedSky {
  Image<glm::vec3> encoded;   // 0..1, before quantisation
  Image<std::uint8_t> cloud;  // 1 where a cloud's share of the light is above 2 %
  Direction sun{0.0, 0.0, 1.0};
  Image<Rgb8> to_8_bit() const;
};
RenderedSky render(const SyntheticSky& sky, const Camera& camera);

// Small deterministic noise from a seed, uniform in [0, 1) and normal.
double hashed_uniform(std::uint64_t seed, std::uint64_t index);
double hashed_normal(std::uint64_t seed, std::uint64_t index);

}  // namespace kasumi::test
