// Darkening towards the rim of the sky camera's picture, from the clear sky itself: the sky's gradient turns with the
// sun, the lens's does not. What T does to the sky's gradient looks much like a lens, though: skies that follow the
// model give the lens to parts of a percent, real ones only when T is known from elsewhere (docs/calibration.md).
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/result.hpp"
#include "calib/camera.hpp"
#include "estimator/sky_camera/sky_moment.hpp"
#include "estimator/turbidity/turbidity.hpp"

namespace kasumi {

// T from elsewhere: a sun photometer nearby, a weather service.
struct KnownTurbidity {
  double value = 3.0, sigma = 0.2;
};

struct SkyVignettingOptions {
  std::optional<KnownTurbidity> turbidity{};  // empty: each picture's own is found along with the lens
  int samples = 3000;                         // of a picture
  // What is refused: a standard deviation of the illumination at the rim beyond this; T unknown and the sun always
  // within so many degrees.
  double largest_rim_sigma = 0.05;
  Radians least_sun_way = from_degrees(15.0);
};

// What one picture gave.
struct SkyMomentUse {
  bool used = false;
  std::string reason;  // why not
  Turbidity turbidity;
  std::vector<glm::dvec2> profile;  // (radius in px, illumination seen over the sky model's), medians of rings
};

struct SkyVignetting {
  Vignetting vignetting;  // about the lens's centre, out to the farthest sample
  // One standard deviation of the illumination at radius_px, relative: by the residuals' scatter, by a sky that differs
  // smoothly from the model as much as the residuals show, and by what T is not sure of.
  double rim_sigma = 0.0;
  // What skies make of that illumination, relative, whose light differs from the model's by 3 %, smoothly: with the
  // distance from the sun (one standard deviation), and with the zenith angle, growing towards the rim (with its sign).
  // The latter no picture by a camera that stays level can tell from a lens.
  double by_3_percent_about_sun = 0.0, by_3_percent_at_rim = 0.0;
  Radians sun_way;        // largest, between two pictures used
  double residual = 0.0;  // root mean square of ln(light seen / modelled)
  std::vector<double> residuals;
  std::vector<SkyMomentUse> moments;  // as they were given
  int pictures = 0;                   // used
};

// `camera` with its lens, orientation and response; its own vignetting is not looked at. Each picture has its own
// exposure; clouds are masked as for an estimate of T, and what stands out of the fit by more than 4 robust standard
// deviations is left aside. Errors (bad_input): no picture shows enough clear sky; the pictures leave it undetermined,
// with how badly (one picture, or the sun always in one place).
Result<SkyVignetting> vignetting_from_sky(const Camera& camera, std::span<const SkyMoment> moments,
                                          const SkyVignettingOptions& options = {});

}  // namespace kasumi
