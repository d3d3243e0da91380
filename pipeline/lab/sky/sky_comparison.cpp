#include "pipeline/lab/sky/sky_comparison.hpp"

#include <algorithm>
#include <cmath>

#include <glm/matrix.hpp>

#include "calib/colour/colorimetry.hpp"
#include "estimator/sky/dome.hpp"

namespace kasumi {

FormulaFlaws flaws_of(SkyKind kind, Turbidity turbidity, const SunDirection& sun, const SunDirection& low_sun) {
  DomeRequest request;
  request.kind = kind;
  request.turbidity = turbidity;
  request.sun = sun;
  FormulaFlaws flaws;
  flaws.kind = kind;

  const DomePainter painter(sky_scene(request));
  const auto luminance = [&](double from_sun_deg) {
    const Direction view = direction_from(zenith_angle(sun), azimuth_angle(sun) + from_degrees(from_sun_deg));
    return sky_text::luminance_of(painter.sky(view));
  };
  double darkest = luminance(180.0);
  for (int degrees = 0; degrees < 180; ++degrees) darkest = std::min(darkest, luminance(degrees));
  flaws.band = darkest / luminance(180.0);

  request.sun = low_sun;
  const glm::dvec3 xyz = glm::inverse(xyz_to_linear_srgb()) * DomePainter(sky_scene(request)).sky({0.0, 0.0, 1.0});
  const double sum = std::max(xyz.x + xyz.y + xyz.z, 1e-9);
  flaws.zenith_x = xyz.x / sum;
  flaws.zenith_y = xyz.y / sum;
  flaws.zenith_luminance = xyz.y;
  return flaws;
}

}  // namespace kasumi
