// A photograph's scene under other air: the papers' composition mode (M Eq 25, 26; physics 8).
#pragma once

#include <cstdint>
#include <optional>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "calib/camera.hpp"
#include "estimator/airlight.hpp"
#include "estimator/attenuation.hpp"

namespace kasumi {

// The air a picture was, or is to be, taken under. No turbidity: no air at all, the scene without haze.
struct PictureAir {
  std::optional<Turbidity> turbidity;
  // Light from infinity in each pixel's direction, in the picture's channels and scale: as large as the picture, or one
  // pixel for all.
  Image<glm::vec3> from_infinity;
};

// Where the paths of light run.
struct PictureDepth {
  Image<float> distance_m;  // along each pixel's line of sight; 0: sky, nothing stands there
  Image<float> rise;        // sine of the line's elevation; empty: all level
  double observer_altitude_m = 0.0;
};

struct RetargetOptions {
  ScatteringModel scattering = ScatteringModel::morales2017;
  // What the light on the scene does, in units of the light from infinity, from the source's air to the target's. 1: as
  // M Eq 25 has it, surfaces keep their L0 / Linf.
  glm::dvec3 relit{1.0};
  // Where a change of the source's light would be amplified more than so many times, nothing is there to restore: the
  // pixel is brought only as much of the way as that allows, some haze stays, and it is masked; the less the fainter it
  // is, until at largest_gain squared it stays as it is, like the sky behind it.
  double largest_gain = 8.0;
};

struct Retargeted {
  Image<glm::vec3> light;           // linear, of the target's scale; >= 0
  Image<std::uint8_t> restored;     // 255; 0 where the source was too faint
  double too_faint_fraction = 0.0;  // of the picture
};

// `light`: linear, vignetting and white balance removed (Camera::light_at). All pictures of one size.
// I_t = Linf_t (1 + k r (I_s / Linf_s - 1) + Gamma_t (k - 1)), r = Gamma_t / Gamma_s, k = relit: M Eq 26 for k = 1. The
// sky keeps its ratio to the light from infinity.
Retargeted retarget(const Image<glm::vec3>& light, const PictureDepth& depth, const PictureAir& source,
                    const PictureAir& target, const AttenuationNodes& nodes, const RetargetOptions& options = {});

// Light from infinity in the direction of each of a camera's pixels.
Image<glm::vec3> light_from_infinity(const Camera& camera, const Airlight& airlight);
// Sines of the elevations in which a camera's pixels look.
Image<float> rise_of(const Camera& camera);
// RetargetOptions::relit for one sun: light on level ground in units of the light from infinity towards `view`, under
// the target's air and under the source's. Without a turbidity: under the clearest air there is.
glm::dvec3 relighting(const Camera& camera, const std::optional<Turbidity>& source,
                      const std::optional<Turbidity>& target, const SunDirection& sun, const Direction& view,
                      double altitude_m);

}  // namespace kasumi
