// A photograph's scene under other air: the papers' composition mode (M Eq 25, 26; physics 8).
#pragma once

#include <cstdint>
#include <optional>

#include <glm/vec3.hpp>

#include "base/image.hpp"
#include "calib/camera.hpp"
#include "estimator/air/attenuation.hpp"
#include "estimator/light/airlight.hpp"

namespace kasumi {

// The air a picture was, or is to be, taken under. No turbidity: no air at all, the scene without haze.
struct PictureAir {
  std::optional<Turbidity> turbidity;
  // Light from infinity in each pixel's direction, in the picture's channels and scale: as large as the picture, or one
  // pixel for all.
  Image<glm::vec3> from_infinity;
  const glm::vec3& of(int x, int y) const {
    return from_infinity.width() == 1 && from_infinity.height() == 1 ? from_infinity.at(0, 0) : from_infinity.at(x, y);
  }
};

// Where the paths of light run.
struct PictureDepth {
  Image<float> distance_m;  // along each pixel's line of sight; 0: sky, nothing stands there
  Image<float> rise;        // sine of the line's elevation; empty: all level
  double observer_altitude_m = 0.0;
  OpticalPath path(int x, int y) const {
    const double rise_of_it = rise.empty() ? 0.0 : static_cast<double>(rise.at(x, y));
    const auto length_m = static_cast<double>(distance_m.at(x, y));
    return optical_path(observer_altitude_m, observer_altitude_m + rise_of_it * length_m, length_m);
  }
};

// What the light on the scene does from the source's air to the target's, in units of the light from infinity. 1: as M
// Eq 25 has it, surfaces keep their L0 / Linf.
struct Relighting {
  glm::dvec3 land{1.0};             // on level ground
  glm::dvec3 sun{1.0}, shade{1.0};  // of it what the sun gives, what the sky gives
};

// What is known of a picture besides, the same for all targets. Empty: nothing.
struct PictureParts {
  Image<glm::vec3> clean;        // the picture without its noise (without_noise), linear: noise is not restored
  Image<glm::vec3> land_around;  // (land_around): sunlit and shaded are told apart
};

struct RetargetOptions {
  ScatteringModel scattering = ScatteringModel::morales2017;
  Relighting relit;
  // How much of the contrast to what is around is sun and shade; the rest is what surfaces are made of. A picture does
  // not tell the one from the other, so neither is preferred.
  double contrast_of_light = 0.5;
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
// I_t = Linf_t (1 - Gamma_t + k J), J = Gamma_t + r (I_s / Linf_s - 1), r = Gamma_t / Gamma_s, k = relit.land: M Eq 26
// for k = 1. The sky keeps its ratio to the light from infinity.
// With land_around m: what is brighter than its surroundings is in the sun by half of that contrast, what is darker in
// shade, and kJ becomes kJ - (k - b) Gamma_t m (J / (Gamma_t m) - 1) with b half-way from k to relit.sun, the quotient
// of greys; never less or more than sun and shade alone would have it. With `clean`: what the picture differs from it
// by is given on as brightly as noise of the camera at the new light is (its square goes with the light), or less.
Retargeted retarget(const Image<glm::vec3>& light, const PictureDepth& depth, const PictureAir& source,
                    const PictureAir& target, const AttenuationNodes& nodes, const RetargetOptions& options = {},
                    const PictureParts& parts = {});

// Light from infinity in the direction of each of a camera's pixels.
Image<glm::vec3> light_from_infinity(const Camera& camera, const Airlight& airlight);
// Sines of the elevations in which a camera's pixels look.
Image<float> rise_of(const Camera& camera);
// For one sun: light on level ground in units of the light from infinity towards `view`, under the target's air and
// under the source's. Without a turbidity: under the clearest air there is.
Relighting relighting(const Camera& camera, const std::optional<Turbidity>& source,
                      const std::optional<Turbidity>& target, const SunDirection& sun, const Direction& view,
                      double altitude_m);

}  // namespace kasumi
