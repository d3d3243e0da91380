// Vignetting of the sky camera, from the clear sky itself: the sky's gradient turns with the sun, the lens's does not.
// T, however, changes the sky's gradient much as a lens does: with skies that follow the model the vignetting is found
// to parts of a percent, with real ones only when T is known from another source (docs/calibration.md).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "calib/camera.hpp"
#include "estimator/sky_camera/sun_moment.hpp"
#include "estimator/turbidity/turbidity.hpp"

namespace kasumi {

// T from another source: a sun photometer nearby, a weather service.
struct KnownTurbidity {
  double value = 3.0, sigma = 0.2;
};

struct VignettingRequest {
  std::optional<KnownTurbidity> turbidity{};  // empty: each picture's own is fitted along with the lens
  int samples = 3000;                         // per picture
  // Limits beyond which the result is refused: the standard deviation of the illumination at the rim, and, with T
  // unknown, a sun that stays within so many degrees.
  double largest_rim_sigma = 0.05;
  Radians least_sun_way = from_degrees(15.0);
};

// The result for one picture.
struct MomentUse {
  bool used = false;
  std::string reason;  // why it is not used
  Turbidity turbidity;
  std::vector<glm::dvec2> profile;  // (radius in px, measured illumination over the sky model's), medians of rings
};

struct FoundVignetting {
  Vignetting vignetting;  // about the lens's centre, out to the farthest sample
  // One standard deviation of the illumination at radius_px, relative: from the residuals' scatter, from a sky that
  // differs smoothly from the model as much as the residuals show, and from the uncertainty of T.
  double rim_sigma = 0.0;
  // The relative change of that illumination if the sky's light differs smoothly from the model's by 3 %: with the
  // distance from the sun (one standard deviation), and with the zenith angle, growing towards the rim (signed).
  // Pictures from a level camera cannot separate the latter from the lens.
  double by_3_percent_about_sun = 0.0, by_3_percent_at_rim = 0.0;
  Radians sun_way;        // largest angle between the sun's positions in two pictures used
  double residual = 0.0;  // root mean square of ln(measured light / modelled)
  std::vector<double> residuals;
  std::vector<MomentUse> moments;  // in the given order
  int pictures = 0;                // used
};

// `camera` supplies lens, orientation and response; its own vignetting is ignored. Each picture has its own exposure;
// clouds are masked as for an estimate of T, and samples off by more than 4 robust standard deviations are left out.
// Errors (bad_input): no picture shows enough clear sky; the pictures leave the vignetting undetermined, with by how
// much (one picture, or the sun always in one place).
Result<FoundVignetting> vignetting_from_sky(const Camera& camera, std::span<const SunMoment> moments,
                                            const VignettingRequest& options = {});

}  // namespace kasumi
