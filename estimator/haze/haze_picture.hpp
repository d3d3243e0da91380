// A photograph under haze that blurs as well as it fades (H Eq 1-7; physics 9). Ranges are in farthest ranges
// (HazeRange), coefficients per farthest range, as H prints them.
#pragma once

#include <array>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "base/image.hpp"
#include "base/result.hpp"
#include "estimator/air/attenuation.hpp"
#include "estimator/haze/diffusion.hpp"
#include "estimator/haze/range.hpp"

namespace kasumi {

// What is left of light: a sum of two exponentials for each channel.
struct HazeOptics {
  std::array<glm::dvec3, kAttenuationNodes> weight{glm::dvec3{1.0}, glm::dvec3{0.0}};  // each channel's sum is 1
  std::array<glm::dvec3, kAttenuationNodes> extinction{};                              // kappa_a + kappa_s
  double scattering = 0.0;                                                             // kappa_s: what blurs
  double lambda = 15.0;   // the widest blur is lambda sqrt(kappa_s), in pixels
  double inner_px = 1.0;  // sigma_0
  glm::dvec3 transmission(double range) const;
  double sigma_px(double range) const;  // H Eq 7
};
// H's own three, the same for all channels (H Eq 1).
HazeOptics haze_optics(double kappa_a, double kappa_s, double lambda);
// For that air along level paths, in a camera's channels; nothing is absorbed. kappa_s is green's.
HazeOptics haze_optics(const AttenuationNodes& nodes, ScatteringModel model, const AirState& air, double altitude_m,
                       double farthest_m, double lambda);

// Widths and steps for `diffuse`.
BlurMap blur_map(const HazeRange& range, const HazeOptics& optics);

// H Eq 2 for channels with unequal attenuation: rgb = Gamma E + (a - Gamma) Linf, a = the largest channel's Gamma. What
// a channel loses beyond `a` is already airlight, so one blurred `a` serves all channels; with equal attenuation this
// is H's tau (E, 1). `light`: linear. All sizes must be the same.
Image<glm::vec4> attenuated(const Image<glm::vec3>& light, const Image<float>& range, const HazeOptics& optics,
                            const glm::dvec3& airlight);
// H Eq 4: F + (1 - a) Linf, with the blurred a.
Image<glm::vec3> composited(const Image<glm::vec4>& blurred, const glm::dvec3& airlight);

struct HazedImage {
  Image<glm::vec3> light;
  DiffusionCost cost;
};
// The whole sequence. Errors: as `diffuse`.
Result<HazedImage> under_haze(const Image<glm::vec3>& light, const HazeRange& range, const HazeOptics& optics,
                              const glm::dvec3& airlight, DiffusionScheme scheme);

}  // namespace kasumi
