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

// The air a picture was taken under, or is to be shown under. Without a state: no air at all, the scene without haze.
struct RetargetAir {
  std::optional<AirState> state;
  // Light from infinity in each pixel's direction, in the picture's channels and scale: at the picture's size, or one
  // pixel for all.
  Image<glm::vec3> from_infinity;
  const glm::vec3& of(int x, int y) const {
    return from_infinity.width() == 1 && from_infinity.height() == 1 ? from_infinity.at(0, 0) : from_infinity.at(x, y);
  }
};

// The geometry of the light paths.
struct RetargetGeometry {
  Image<float> distance_m;  // along each pixel's line of sight; 0: sky
  Image<float> rise;        // sine of the line's elevation; empty: all level
  double observer_altitude_m = 0.0;
  OpticalPath path(int x, int y) const {
    const double rise_of_it = rise.empty() ? 0.0 : static_cast<double>(rise.at(x, y));
    const auto length_m = static_cast<double>(distance_m.at(x, y));
    return optical_path(observer_altitude_m, observer_altitude_m + rise_of_it * length_m, length_m);
  }
};

// How the light on the scene changes from the source's air to the target's, in units of the light from infinity. 1: as
// in M Eq 25, surfaces keep their L0 / Linf.
struct Relighting {
  glm::dvec3 land{1.0};             // on level ground
  glm::dvec3 sun{1.0}, shade{1.0};  // its parts from the sun and from the sky
};

// Optional further knowledge of a picture, the same for all targets. Empty: none.
struct RetargetHints {
  Image<glm::vec3> clean;        // the picture without its noise (without_noise), linear: noise is not restored
  Image<glm::vec3> land_around;  // (land_around): distinguishes sunlit from shaded
};

struct RetargetLimits {
  ScatteringModel scattering = ScatteringModel::morales2017;
  Relighting relit;
  // How much of the contrast to the surroundings is sun and shade; the rest is the surfaces' reflectance. A picture
  // cannot separate the two, so neither is preferred.
  double contrast_of_light = 0.5;
  // Limit of the amplification. Where a change of the source's light would be amplified more than this, there is
  // nothing to restore: the pixel is changed only as far as the limit allows, some haze stays, and the pixel is masked.
  // The fainter it is the less it changes; from largest_gain squared on it stays unchanged, like the sky behind it.
  double largest_gain = 8.0;
  bool terms = false;  // also give airlight and direct transmission apart
};

struct Retargeted {
  Image<glm::vec3> light;           // linear, in the target's scale; >= 0
  Image<std::uint8_t> restored;     // 255; 0 where the source was too faint
  double too_faint_fraction = 0.0;  // of the picture
  // With `terms`: the part of `light` that the air scatters in, Linf_t (1 - Gamma_t), all of it in the sky, and never
  // more than there is. The rest of `light` is direct transmission.
  Image<glm::vec3> airlight{};
};

// `light`: linear, vignetting and white balance removed (Camera::light_at). All pictures of one size. I_t = Linf_t (1 -
// Gamma_t + k J), J = Gamma_t + r (I_s / Linf_s - 1), r = Gamma_t / Gamma_s, k = relit.land: M Eq 26 for k = 1. The sky
// keeps its ratio to the light from infinity. With land_around m: what is brighter than its surroundings is in the sun
// by half of that contrast, what is darker is in shade, and kJ becomes kJ - (k - b) Gamma_t m (J / (Gamma_t m) - 1)
// with b half-way from k to relit.sun, the quotient of greys; limited to what sun and shade alone would give. With
// `clean`: the picture's difference from it is kept at the brightness that camera noise would have at the new light
// (its square is proportional to the light), or less.
Retargeted retarget(const Image<glm::vec3>& light, const RetargetGeometry& depth, const RetargetAir& source,
                    const RetargetAir& target, const AttenuationNodes& nodes, const RetargetLimits& options = {},
                    const RetargetHints& parts = {});

// The sky of a photograph: the dome's where the aerosol is known; else T is the papers', and Preetham's is, at any
// altitude: the dome's table ends long before that T does.
DaylightModel sky_model_of(const AirState& air);
// What stands for no air where a sky is needed: T 1.7, or molecules alone where the aerosol is known.
AirState clearest_like(const std::optional<AirState>& air);

// Light from infinity in the direction of each of a camera's pixels.
Image<glm::vec3> light_from_infinity(const Camera& camera, const Airlight& airlight);
// Sine of the elevation of each pixel's line of sight.
Image<float> rise_of(const Camera& camera);
// For one sun position: light on level ground in units of the light from infinity towards `view`, under the target's
// air and under the source's. Nothing: under the clearest air there is.
Relighting relighting(const Camera& camera, const std::optional<AirState>& source,
                      const std::optional<AirState>& target, const SunDirection& sun, const Direction& view,
                      double altitude_m);

}  // namespace kasumi
